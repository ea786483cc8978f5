"""The nodes of `isaacsim.core.nodes`: time, state and pose, render products."""
