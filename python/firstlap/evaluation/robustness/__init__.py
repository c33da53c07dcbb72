"""Races under errors of sensors, car and track."""
