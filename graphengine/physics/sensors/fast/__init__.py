"""Ray casting through a tree of boxes, compiled by numba: the optional extra `fast`."""
