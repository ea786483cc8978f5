"""ROS 2 messages without a network: definitions, encoding, names, quality of service, text."""
