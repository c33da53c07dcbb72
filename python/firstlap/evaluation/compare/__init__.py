"""Drivers against each other on one track."""
