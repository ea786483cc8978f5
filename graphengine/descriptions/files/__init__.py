"""Reads untrusted files from allowed folders, limits their size and depth, and converts meshes in confined processes."""
