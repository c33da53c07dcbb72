"""Where to drive: the racing line."""
