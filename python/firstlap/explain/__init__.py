"""One step of a driver, in a picture."""
