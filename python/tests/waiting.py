"""Timeout of tests for a process or a thread; it detects hangs, not slowness."""

PATIENCE = 300.0
"""[s] Timeout."""
