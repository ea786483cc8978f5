"""The transport over DDS without ROS."""
