"""Comparison of drivers on one track."""
