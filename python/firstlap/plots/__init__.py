"""What all pictures share: colors, figures, a track, a race."""
