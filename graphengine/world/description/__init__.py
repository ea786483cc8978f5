"""Robot descriptions as their authors keep them: xacro, ROS packages, meshes of many formats."""
