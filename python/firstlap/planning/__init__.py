"""Planning: the racing line."""
