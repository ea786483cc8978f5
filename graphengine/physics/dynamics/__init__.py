"""Laws that act on a running model: joint commands, directed friction, moving surfaces, pushes, welds and settings."""
