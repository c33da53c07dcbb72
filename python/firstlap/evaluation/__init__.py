"""Evaluation of drivers, maps, localization and perception."""
