"""The public Python API: scenes, sessions, port values, topics and robots. Users import its names from `graphengine`."""
