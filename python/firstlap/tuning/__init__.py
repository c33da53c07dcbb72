"""Tuning: from a setup to the fastest that holds."""
