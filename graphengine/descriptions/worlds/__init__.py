"""Parts that worlds of several formats share when they are converted to MJCF."""
