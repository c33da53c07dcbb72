"""The map-based driver: map, line, localisation and predictive control in one chain."""
