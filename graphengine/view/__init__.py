"""The web page of a run: its process, the data sent to it, and access control."""
