"""ROS 2 message types, messages, names and QoS, and the interface of nodes to a network; no live network is needed."""
