"""The transport over an installed ROS 2."""
