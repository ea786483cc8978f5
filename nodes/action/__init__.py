"""Events and flow control (`omni.graph.action`)."""
