"""What the car's own measurements are worth."""
