"""Reads URDF, in `urdf_reader` and `link_parts`, and writes URDF, in `urdf_writer`."""
