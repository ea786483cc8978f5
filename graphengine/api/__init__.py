"""The public Python API: scenes, sessions, values of ports, topics, robots; `graphengine` itself offers its names."""
