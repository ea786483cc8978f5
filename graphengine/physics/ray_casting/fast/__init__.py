"""Ray casting with trees of bounding boxes, compiled by numba; needs the optional extra `fast`."""
