"""The generated pages of the reference, each a text by its path below docs/reference."""
