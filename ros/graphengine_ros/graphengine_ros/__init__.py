"""Launches simulations of graphengine, which is installed in a Python environment of its own."""
