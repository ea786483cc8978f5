"""Handles by which nodes read and write poses, joints, conveyors and entities of a running simulation."""
