"""What the method perceives, measured against what is there."""
