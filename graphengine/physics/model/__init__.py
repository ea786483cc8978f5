"""Builds the world and the robots of a scene: as editable MuJoCo models (`MjSpec`), and as prims of a stage."""
