"""Controllers of wheeled bases (`isaacsim.robot.wheeled_robots`), one node type per file."""
