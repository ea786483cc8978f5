"""The public Python API: scenes, sessions, port values, topics and robots. `graphengine` exports its names."""
