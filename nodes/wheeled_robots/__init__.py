"""Controllers of wheeled bases (`isaacsim.robot.wheeled_robots`), one a file."""
