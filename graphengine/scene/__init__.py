"""Loads scenes and starts sessions: the only package that combines physics, network and graphs."""
