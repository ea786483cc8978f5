"""Prims as USD shows them: their types, and attributes with their values."""
