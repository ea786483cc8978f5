def clock():
    return "isaacsim.ros2.bridge.ROS2PublishClock"
