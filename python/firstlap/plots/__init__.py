"""Colors, figures, and plots of tracks and races, shared by all plots."""
