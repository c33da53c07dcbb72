"""The map-based driver: map, line, localization and predictive control in one chain."""
