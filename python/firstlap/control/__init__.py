"""Control: model predictive control along a line."""
