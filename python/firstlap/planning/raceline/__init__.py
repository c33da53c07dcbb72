"""The optimal racing line on a known map, computed offline."""
