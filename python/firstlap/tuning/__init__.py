"""Tuning: searches for the fastest reliable setup."""
