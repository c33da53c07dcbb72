"""Errors of the state estimate, by simulated sensor errors."""
