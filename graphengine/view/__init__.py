"""The page on which a run is seen: its process, what it is fed, and who may look."""
