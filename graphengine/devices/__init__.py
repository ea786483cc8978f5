"""The interfaces of devices and of the world, the prim tree, and a world without physics for checks."""
