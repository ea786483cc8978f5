"""Drives of joints in SI units, and MuJoCo models with their actuators and keyframes."""
