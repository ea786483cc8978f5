"""Nodes for wheeled bases (`isaacsim.robot.wheeled_robots`): controllers, odometry, path planning and path following."""
