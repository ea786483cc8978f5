"""The web page of a run: the page's process, the data that a run sends to it, and access control."""
