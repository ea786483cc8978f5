"""Explains why a robot stands still."""
