"""Drivers on recordings."""
