"""Ablation: the method with one rule turned off at a time."""
