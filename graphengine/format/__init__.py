"""Reads graph, scene and robot files as validated specs, reports errors in them, and controls which files may be read."""
