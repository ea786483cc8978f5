"""Occupancy maps: computes exactly which cells of a floor plan are occupied, writes map files, and judges localizability."""
