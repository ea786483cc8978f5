"""What can be asked of a running session from outside of its thread: by other threads, and by other programs of its user."""
