"""Errors, files and text that all other packages use."""
