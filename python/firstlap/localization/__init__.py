"""Where the car is on a map: the second of the map-based driver's eyes."""
