"""Rays through a tree of boxes, compiled by numba: what the optional extra `fast` brings."""
