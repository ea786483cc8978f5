"""The interfaces of devices and of the world that has them, the prim tree, and a world without physics for checks."""
