"""Camera images: captures of the state, rendered off screen in a separate thread, and views for users."""
