"""URDF: `urdf_reader` and `link_parts` read it, and `urdf_writer` writes it."""
