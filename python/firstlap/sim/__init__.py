"""Races in the simulator."""
