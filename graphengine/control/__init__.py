"""Lets other programs control a running session: over the socket of `graphrun ctl`, simulation_interfaces and ROS parameters."""
