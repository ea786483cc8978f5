"""The interfaces of the world and of its devices (sensors and grippers), the prim tree, and a world without physics."""
