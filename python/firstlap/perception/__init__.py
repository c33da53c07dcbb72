"""Scans, what is wrong with them, and where the laser sits."""
