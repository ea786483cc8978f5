"""Event nodes and flow control nodes (`omni.graph.action`)."""
