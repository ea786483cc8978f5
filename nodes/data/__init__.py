"""Nodes that compute values from their inputs (`omni.graph.nodes`)."""
