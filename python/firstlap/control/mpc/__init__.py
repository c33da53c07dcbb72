"""Model predictive control along a line."""
