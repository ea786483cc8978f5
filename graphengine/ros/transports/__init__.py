"""The transports that carry messages between ROS 2 programs, and the choice between them."""
