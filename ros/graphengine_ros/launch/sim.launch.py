"""Runs a scene with robot_state_publisher, and on request with RViz and Nav2.

ros2 launch graphengine_ros sim.launch.py scene:=dd100_warehouse rviz:=true nav2:=true
"""

from graphengine_ros.simulation_launch import generate_launch_description

__all__ = ["generate_launch_description"]
