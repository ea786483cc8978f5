"""Values computed from values (`omni.graph.nodes`)."""
