"""Prims in USD's terms: types, attributes and attribute values."""
