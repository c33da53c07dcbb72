"""Localization on a map with a particle filter."""
