"""The optimal line on a known map, offline."""
