"""Drives of joints in SI units, the actuators of a MuJoCo model, and the model that has them."""
