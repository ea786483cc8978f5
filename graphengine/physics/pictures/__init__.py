"""What cameras see: a state captured as a scene, drawn without a window by a thread of its own, and views for people."""
