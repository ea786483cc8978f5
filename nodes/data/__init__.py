"""Data nodes that compute values (`omni.graph.nodes`)."""
