"""Generates the files that Nav2 needs to drive the robots of a scene: parameters, map, launch file, RViz configuration."""
