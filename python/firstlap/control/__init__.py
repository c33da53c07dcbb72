"""How to follow a line: model predictive control."""
