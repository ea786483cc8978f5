"""Launches simulations with graphengine, which is installed in a separate Python environment."""
