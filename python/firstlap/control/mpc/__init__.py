"""Predictive control along a line."""
