"""Setups, cars and driver kinds: their field tables and files."""
