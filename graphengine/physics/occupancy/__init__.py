"""Occupancy maps: the exact cells of a floor plan that obstacles occupy, and the files of map_server."""
