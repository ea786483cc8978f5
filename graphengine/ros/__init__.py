"""The ROS 2 network: endpoints of a session, discovery of peers, and the transports that carry messages."""
