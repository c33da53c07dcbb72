"""Setups, cars and drivers: their field tables and files."""
