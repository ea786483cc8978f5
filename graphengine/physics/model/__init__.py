"""Builds the world and the robots of a scene as MuJoCo's editable models, and as the prims of a stage."""
