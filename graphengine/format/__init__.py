"""Reads graph, scene and robot files as validated specs, reports errors in the files, and controls which files may be read."""
