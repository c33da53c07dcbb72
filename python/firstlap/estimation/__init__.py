"""Checks of the car's own measurements."""
