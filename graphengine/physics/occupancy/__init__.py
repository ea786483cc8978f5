"""Occupancy maps: computes exactly which cells of a floor plan are occupied."""
