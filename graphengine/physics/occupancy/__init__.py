"""Occupancy maps: the exact cells of a floor plan that obstacles occupy, and the files for map_server."""
