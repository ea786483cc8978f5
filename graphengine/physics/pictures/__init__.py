"""Renders camera images off screen in a separate thread, and views of a scene for users."""
