"""Makes an occupancy map from scans and odometry."""
