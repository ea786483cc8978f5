"""The ROS 2 seam: message definitions, names, and the transports that carry them."""
