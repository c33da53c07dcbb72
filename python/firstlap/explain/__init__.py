"""Plots of single steps of drivers."""
