"""Camera pictures: captures of the state, rendered off screen by a thread of their own, and views for people."""
