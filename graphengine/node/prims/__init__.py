"""Access to the prims of a world by USD types and USD attributes."""
