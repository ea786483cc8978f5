"""Calibration of a mobile robot: test drives on a flat floor, and figures measured from them."""
