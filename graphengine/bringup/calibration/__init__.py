"""Calibrates a mobile robot: runs test drives on a flat floor and measures radius, track, odometry errors and noise."""
