"""The README in the folder that `graphrun nav2 files` writes."""

from __future__ import annotations

from collections.abc import Sequence

from graphengine.api.nav2.robot_facts import RobotFacts


def readme_file(scene: str, robots: Sequence[RobotFacts], *, slam: bool, robot_state: bool, described: bool) -> str:
    """Return the text of the README of a folder with Nav2 files.

    Args:
        scene: name of the scene.
        robots: properties of the robots for which the folder has files.
        slam: whether slam_toolbox builds the map.
        robot_state: whether the simulation has to run with `--robot-state`.
        described: whether the run publishes the descriptions of all robots.
    """
    run = f"graphrun run SCENE{' --robot-state' if robot_state else ''}"
    names = ", ".join(robot.name for robot in robots)
    place = "in the folder of each robot" if len(robots) > 1 else "in this folder"
    other = " `params_file:=FILE` selects another file." if len(robots) == 1 else ""
    goal, mapped = robots[0].topic("goal_pose"), robots[0].topic("map")
    lines = [
        f"# Nav2 for {names} in {scene}",
        "",
        f"1. Start the simulation: `{run}`. SCENE is the scene file from which these files were made.",
        "2. In another terminal with a sourced ROS 2: `ros2 launch nav2.launch.py rviz:=true`.",
        f'3. In RViz, set a goal with "2D Goal Pose" ({goal}), or run `graphrun nav2 goals "X Y YAW"`.',
        "",
        f"- `nav2_params.yaml` ({place}): the comment at each value names its source.{other}",
        f"- slam_toolbox builds the map; this saves it: `ros2 run nav2_map_server map_saver_cli -t {mapped} -f map`."
        if slam
        else "- `map.yaml`, `map.pgm`: occupancy map of the obstacles up to the robot's height. `map:=FILE` selects another map.",
        *([] if described else ["- RViz shows the links of the robot if the simulation runs with `--robot-state`."]),
        "- `ros2 launch nav2.launch.py --show-args` lists the arguments: `namespace`, `autostart`, `use_respawn`, `log_level`, …",
        *(
            []
            if slam
            else [
                f"- `localization:=truth` runs without AMCL. It needs a simulation that runs with `{run} --localization truth`."
            ]
        ),
        "- After a change of the robot or the scene, write the files again: `graphrun nav2 files SCENE -o DIR --force`.",
    ]
    return "\n".join(lines) + "\n"
