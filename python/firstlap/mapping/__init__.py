"""From scans and odometry to an occupancy map: the first of the map-based driver's eyes."""
