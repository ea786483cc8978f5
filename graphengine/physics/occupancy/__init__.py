"""Occupancy maps: which cells of the floor plan a scene's obstacles stand in, exact, and the two files that map_server reads."""
