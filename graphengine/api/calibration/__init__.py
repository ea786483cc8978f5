"""Calibration of a mobile robot: test drives on a flat floor, and the measurements taken in these drives."""
