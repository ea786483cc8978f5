"""ROS 2 nodes (`isaacsim.ros2.bridge`)."""
