"""Loads scenes and starts sessions; only this package combines physics, network and graphs."""
