"""Public robots by `graphrun new` and `graphrun calibrate`, as a table: `python -m tests.bench.public_robots FOLDER [NAME …]`.

FOLDER holds clones of the repositories by their own names. Each description is imported with nothing but the arguments that its
vendor's launch file passes; no file is edited. `--write` renews the table in docs/reference/robots.md. Nothing is asserted.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

PAGE = Path(__file__).resolve().parents[2] / "docs/reference/robots.md"
BEGIN, END = "<!-- table: python -m tests.bench.public_robots FOLDER --write -->", "<!-- end of table -->"
LIMIT = 600.0
"""Seconds for one command."""


@dataclass(frozen=True)
class Robot:
    """A public description.

    Attributes:
        name: for people.
        repository: owner and name on GitHub.
        file: the description in the repository.
        arguments: what `graphrun new` gets besides `--from` and the package path.
    """

    name: str
    repository: str
    file: str
    arguments: tuple[str, ...] = ()

    @property
    def folder(self) -> str:
        """Name of the clone."""
        return self.repository.partition("/")[2]


ROBOTS = (
    Robot(
        "TurtleBot3 burger",
        "ROBOTIS-GIT/turtlebot3",
        "turtlebot3_description/urdf/turtlebot3_burger.urdf",
        ("namespace:=",),
    ),
    Robot(
        "TurtleBot4",
        "turtlebot/turtlebot4",
        "turtlebot4_description/urdf/standard/turtlebot4.urdf.xacro",
        ("gazebo:=ignition", "namespace:="),
    ),
    Robot(
        "Clearpath A200",
        "clearpathrobotics/clearpath_common",
        "clearpath_platform_description/urdf/a200/a200.urdf.xacro",
        ("--macro", "a200", "--controllers", "{repository}/clearpath_control/config/a200/control.yaml"),
    ),
    Robot(
        "Clearpath Dingo-O",
        "clearpathrobotics/clearpath_common",
        "clearpath_platform_description/urdf/do100/do100.urdf.xacro",
        ("--macro", "do100", "--controllers", "{repository}/clearpath_control/config/do100/control.yaml"),
    ),
    Robot(
        "ROSbot",
        "husarion/rosbot_ros",
        "rosbot_description/urdf/rosbot.urdf.xacro",
        (
            "mecanum:=true",
            "use_sim:=true",
            "--controllers",
            "{repository}/rosbot_controller/config/mecanum_drive_controller.yaml",
        ),
    ),
    Robot(
        "Ackermann demo",
        "ros-controls/gz_ros2_control",
        "gz_ros2_control_demos/urdf/test_ackermann_drive.xacro.urdf",
    ),
    Robot("racecar", "mit-racecar/racecar_gazebo", "racecar_description/urdf/racecar.xacro"),
    Robot("Fetch", "ZebraDevs/fetch_ros", "fetch_description/robots/fetch.urdf"),
)
NEVER_TUNED_TO = (
    Robot("Andino", "Ekumen-OS/andino", "andino_description/urdf/andino.urdf.xacro"),
    Robot("Leo Rover", "LeoRover/leo_common-ros2", "leo_description/urdf/leo.urdf.xacro", ("mecanum_wheels:=false",)),
    Robot("PMB-2", "pal-robotics/pmb2_robot", "pmb2_description/robots/pmb2.urdf.xacro"),
    Robot("Scout 2", "agilexrobotics/scout_ros2", "scout_description/urdf/scout_v2.xacro"),
    Robot(
        "Summit XL",
        "RobotnikAutomation/summit_xl_common",
        "summit_xl_description/robots/summit_xl_std.urdf.xacro",
        ("prefix:=summit_xl_", "omni_wheels:=false", "gpu:=false", "ros_planar_move_plugin:=false"),
    ),
    Robot("Linorobot2 4wd", "linorobot/linorobot2", "linorobot2_description/urdf/robots/4wd.urdf.xacro"),
    Robot("Linorobot2 mecanum", "linorobot/linorobot2", "linorobot2_description/urdf/robots/mecanum.urdf.xacro"),
    Robot("Magni", "UbiquityRobotics/magni_robot", "magni_description/urdf/magni.urdf.xacro"),
)
"""Chosen before anything of them was imported; no code was changed for them."""


def graphrun(*arguments: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run the program in a folder to its end."""
    command = [sys.executable, "-m", "graphengine.cli", *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=LIMIT, check=False)


def measure(robot: Robot, clones: Path, folder: Path) -> dict[str, Any]:
    """Import a robot into a folder and calibrate it; return the table's cells."""
    begin = time.perf_counter()
    project = robot.name.replace(" ", "_").replace("-", "_")
    arguments = [text.format(repository=clones / robot.folder) for text in robot.arguments]
    source = ["--from", str(clones / robot.folder / robot.file), "--package-path", str(clones)]
    made = graphrun("new", project, *source, *arguments, folder=folder)
    (folder / f"{project}.log").write_text(made.stdout + made.stderr)
    if made.returncode:
        return {"robot": robot.name, "result": f"not imported: {_first_error(made.stderr)}"}
    checked = graphrun("check", f"{project}.yaml", "--strict", folder=folder / project)
    (folder / f"{project}.check").write_text(checked.stdout + checked.stderr)
    done = graphrun("calibrate", f"{project}.yaml", "--format", "json", "--check", "0.02", folder=folder / project)
    (folder / f"{project}.calibrate").write_text(done.stdout + done.stderr)
    try:
        found = json.loads(done.stdout)
    except ValueError:
        return {"robot": robot.name, "result": f"not calibrated: {_first_error(done.stderr)}"}
    return {
        "robot": robot.name,
        "kinematics": found["kinematics"] or "unknown",
        **{kind: _shares(found["motions"], kind) for kind in ("straight", "turn", "sideways")},
        "odometry": _odometry(found["odometry"]),
        "check": "clean" if checked.returncode == 0 else checked.stdout.strip().splitlines()[-1],
        "result": "in bounds" if done.returncode == 0 else "out of bounds",
        "seconds": f"{time.perf_counter() - begin:.0f}",
    }


def _first_error(text: str) -> str:
    lines = [line for line in text.splitlines() if "error" in line] or text.splitlines() or ["no output"]
    return lines[0].rpartition("error ")[2]


def _shares(motions: list[dict[str, Any]], kind: str) -> str:
    shares = [motion["share"] for motion in motions if motion["kind"] == kind and motion["share"] is not None]
    return " / ".join(f"{100 * share:.1f}" for share in shares) or "-"


def _odometry(found: list[dict[str, Any]]) -> str:
    """What the wheels' odometry errs by; ground truth is not shown."""
    wheels = [each for each in found if "ground_truth" not in each["topic"]]
    if not wheels or wheels[0]["distance_error"] is None:
        return "-"
    turn = wheels[0]["turn_error"]
    return f"{1000 * wheels[0]['distance_error']:.1f} mm/m" + (f", {turn:.3f} rad a turn" if turn is not None else "")


COLUMNS = {
    "robot": "robot",
    "kinematics": "kinematics",
    "straight": "straight, %",
    "turn": "turn, %",
    "sideways": "sideways, %",
    "odometry": "odometry errs by",
    "check": "`check --strict`",
    "result": "2 % straight, 3 % else",
    "seconds": "all in, s",
}


def table(rows: list[dict[str, Any]]) -> str:
    """Return the rows as a Markdown table."""
    lines = ["| " + " | ".join(COLUMNS.values()) + " |", "|" + "---|" * len(COLUMNS)]
    lines += ["| " + " | ".join(str(row.get(column, "-")) for column in COLUMNS) + " |" for row in rows]
    return "\n".join(lines)


def main() -> None:
    """Measure the robots and print, or write, the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--keep", type=Path, help="folder for the projects and their logs")
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    known = (*ROBOTS, *NEVER_TUNED_TO)
    present = [robot for robot in known if (given.folder / robot.folder).is_dir()]
    chosen = [
        robot for robot in present if not given.names or any(n.lower() in robot.name.lower() for n in given.names)
    ]
    with tempfile.TemporaryDirectory() as scratch, ThreadPoolExecutor(2) as pool:
        folder = given.keep or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        rows = list(pool.map(lambda robot: measure(robot, given.folder.resolve(), folder), chosen))
    print(table(rows))
    if given.write:
        text = PAGE.read_text(encoding="utf-8")
        head, tail = text.partition(BEGIN)[0], text.partition(END)[2]
        PAGE.write_text(f"{head}{BEGIN}\n\n{table(rows)}\n\n{END}{tail}", encoding="utf-8")


if __name__ == "__main__":
    main()
