"""Renders camera images off screen in a separate thread."""
