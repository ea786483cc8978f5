"""Nodes of `isaacsim.core.nodes` for time, robot states, poses, images, render products and viewports."""
