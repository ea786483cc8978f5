"""Public robots by `graphrun new`, as tables: `python -m tests.bench.public_robots FOLDER [NAME …]`.

FOLDER holds clones of the repositories by their own names. Each description is imported with nothing but the arguments that its
vendor's launch file passes; no file is edited. `graphrun calibrate` measures bases, tests/bench/arm_figures.py measures arms in a
bent pose that the scene gives, and tests/bench/leg_figures.py legs. `--write` renews the tables in docs/reference/robots.md.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/reference/robots.md"
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
        pose: in which an arm starts, rad or m by joint; none for a base without an arm.
        flange: link that carries an arm's payload.
        legs: whether it stands on legs.
    """

    name: str
    repository: str
    file: str
    arguments: tuple[str, ...] = ()
    pose: dict[str, float] = field(default_factory=dict)
    flange: str = ""
    legs: bool = False

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
    Robot(
        "Fetch",
        "ZebraDevs/fetch_ros",
        "fetch_description/robots/fetch.urdf",
        pose={
            "torso_lift_joint": 0.1,
            "shoulder_pan_joint": 0.4,
            "shoulder_lift_joint": -0.4,
            "elbow_flex_joint": 1.2,
            "wrist_flex_joint": 0.8,
        },
        flange="gripper_link",
    ),
    Robot(
        "UR5e",
        "UniversalRobots/Universal_Robots_ROS2_Description",
        "urdf/ur.urdf.xacro",
        ("name:=ur", "ur_type:=ur5e"),
        {"shoulder_lift_joint": -1.57, "elbow_joint": 1.57, "wrist_1_joint": -1.57, "wrist_2_joint": -1.57},
        "tool0",
    ),
    Robot(
        "FR3",
        "frankarobotics/franka_description",
        "robots/fr3/fr3.urdf.xacro",
        pose={
            "fr3_joint2": -0.785,
            "fr3_joint4": -2.356,
            "fr3_joint6": 1.571,
            "fr3_joint7": 0.785,
        },
        flange="fr3_link8",
    ),
    Robot(
        "Gen3",
        "Kinovarobotics/ros2_kortex",
        "kortex_description/robots/kinova.urdf.xacro",
        ("arm:=gen3", "name:=gen3"),
        {"joint_2": 0.26, "joint_3": 3.14, "joint_4": -2.2, "joint_6": 0.96, "joint_7": 1.57},
        "end_effector_link",
    ),
    Robot("Go2", "unitreerobotics/unitree_mujoco", "unitree_robots/go2/go2.xml", legs=True),
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
    Robot(
        "Panther",
        "husarion/husarion_ugv_ros",
        "husarion_ugv_description/urdf/panther.urdf.xacro",
        (
            "use_sim:=True",
            "imu_xyz:=0.168 0.028 0.083",
            "imu_rpy:=3.14 -1.57 0.0",
            "namespace:=",
            "battery_config_file:={repository}/husarion_ugv_gazebo/config/battery_plugin.yaml",
        ),
    ),
    Robot(
        "MiR100",
        "DFKI-NI/mir_robot",
        "mir_description/urdf/mir.urdf.xacro",
        (
            "mir_type:=mir_100",
            "tf_prefix:=",
            "--controllers",
            "{repository}/mir_description/config/diffdrive_controller.yaml",
        ),
    ),
    Robot("MPO-500", "neobotix/neo_simulation2", "robots/mpo_500/mpo_500.urdf"),
    Robot(
        "articubot_one",
        "joshnewans/articubot_one",
        "description/robot.urdf.xacro",
        ("use_ros2_control:=true", "sim_mode:=true"),
    ),
    Robot("Kobuki", "kobuki-base/kobuki_ros", "kobuki_description/urdf/kobuki_standalone.urdf.xacro"),
    Robot(
        "xArm6",
        "xArm-Developer/xarm_ros2",
        "xarm_description/urdf/xarm_device.urdf.xacro",
        (
            *("prefix:=", "dof:=6", "robot_type:=xarm", "add_gripper:=False", "add_vacuum_gripper:=False"),
            *("hw_ns:=xarm", "limited:=False", "effort_control:=False", "velocity_control:=False"),
            *("ros2_control_plugin:=gazebo_ros2_control/GazeboSystem", "add_other_geometry:=False"),
        ),
        pose={"joint2": -0.6, "joint3": -0.9, "joint5": 0.8},
        flange="link6",
    ),
    Robot(
        "iiwa7",
        "lbr-stack/lbr_fri_ros2_stack",
        "lbr_description/urdf/iiwa7/iiwa7.xacro",
        ("robot_name:=lbr", "mode:=gazebo"),
        pose={"lbr_A2": 0.6, "lbr_A4": -1.4, "lbr_A6": 1.0},
        flange="lbr_link_ee",
    ),
    Robot(
        "A1",
        "unitreerobotics/unitree_ros",
        "robots/a1_description/xacro/robot.xacro",
        ("DEBUG:=false",),
        legs=True,
    ),
)
"""Chosen before anything of them was imported; no code was changed for them."""


def graphrun(*arguments: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run the program in a folder to its end."""
    command = [sys.executable, "-m", "graphengine.cli", *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=LIMIT, check=False)


def measure(robot: Robot, clones: Path, folder: Path) -> dict[str, dict[str, Any]]:
    """Import a robot into a folder and measure its base and its arm; return the cells of its row in each table."""
    begin = time.perf_counter()
    project = robot.name.replace(" ", "_").replace("-", "_")
    arguments = [text.format(repository=clones / robot.folder) for text in robot.arguments]
    source = ["--from", str(clones / robot.folder / robot.file), "--package-path", str(clones)]
    made = graphrun("new", project, *source, *arguments, folder=folder)
    (folder / f"{project}.log").write_text(made.stdout + made.stderr)
    kind = "legs" if robot.legs else "arm" if robot.pose else "base"
    if made.returncode:
        return {kind: {"robot": robot.name, "result": f"not imported: {_first_error(made.stderr)}"}}
    scene = folder / project / f"{project}.yaml"
    _bend(scene, robot.pose)
    checked = graphrun("check", scene.name, "--strict", folder=scene.parent)
    (folder / f"{project}.check").write_text(checked.stdout + checked.stderr)
    row = {
        "robot": robot.name,
        "check": "clean" if checked.returncode == 0 else checked.stdout.strip().splitlines()[-1],
    }
    rows = {}
    if "graphs/base/" in (scene.parent / "robots" / scene.name).read_text(encoding="utf-8"):
        rows["base"] = row | _base(scene, folder / f"{project}.calibrate")
    elif kind == "base":
        rows["base"] = row | {"result": f"not driven: {_last_remark(made.stdout, 'noticed: nothing moves')}"}
    if robot.pose:
        rows["arm"] = row | _arm(scene, robot.flange, folder / f"{project}.arm")
    if robot.legs:
        rows["legs"] = row | _legs(scene, folder / f"{project}.legs")
    seconds = f"{time.perf_counter() - begin:.0f}"
    return {name: cells | {"seconds": seconds} for name, cells in rows.items()}


def _last_remark(report: str, beginning: str) -> str:
    """What the report of an import says with such a beginning."""
    found = [line.partition(": ")[2].rpartition(" (")[0] for line in report.splitlines() if line.startswith(beginning)]
    return found[-1] if found else "no graph of a base"


def _bend(scene: Path, pose: dict[str, float]) -> None:
    """Let the robot of a new scene start in a pose."""
    if pose:
        starts = ", ".join(f"{joint}: {{start: {position}}}" for joint, position in pose.items())
        text = scene.read_text(encoding="utf-8")
        scene.write_text(
            text.replace("    robot_state:", f"    joints: {{{starts}}}\n    robot_state:"), encoding="utf-8"
        )


def _base(scene: Path, log: Path) -> dict[str, Any]:
    """How the base of a scene follows its commands."""
    done = graphrun("calibrate", scene.name, "--format", "json", "--check", "0.02", folder=scene.parent)
    log.write_text(done.stdout + done.stderr)
    try:
        found = json.loads(done.stdout)
    except ValueError:
        return {"result": f"not calibrated: {_first_error(done.stderr)}"}
    return {
        "kinematics": found["kinematics"] or "unknown",
        **{kind: _shares(found["motions"], kind) for kind in ("straight", "turn", "sideways")},
        "odometry": _odometry(found["odometry"]),
        "result": "in bounds" if done.returncode == 0 else "out of bounds",
    }


BOUNDS = {"hold": 1.0, "points": 5.0, "end": 1.0, "points_payload": 10.0}
"""Largest errors of an arm, mrad."""


def _arm(scene: Path, flange: str, log: Path) -> dict[str, Any]:
    """How the arm of a scene holds its pose and follows trajectories."""
    found = _figures("arm_figures", [str(scene.resolve()), "--flange", flange], log)
    if "result" in found:
        return found
    good = all(found[name] <= bound for name, bound in BOUNDS.items()) and found["code"] == found["code_payload"] == 0
    return {
        "joints": found["joints"],
        **{name: f"{found[name]:.2f}" for name in ("hold", "points", "end", "hold_payload", "points_payload")},
        "goals": f"{sum(found['goals'].values())} of {len(found['goals'])}",
        "result": "in bounds" if good and all(found["goals"].values()) else "out of bounds",
    }


STANDING = 20.0
"""Largest change of the height of a robot on legs, mm."""


def _legs(scene: Path, log: Path) -> dict[str, Any]:
    """How the robot of a scene stands on its legs."""
    found = _figures("leg_figures", [str(scene.resolve())], log)
    if "result" in found:
        return found
    good = all(abs(found[kind]) <= STANDING and found[f"tilt_{kind}"] < 20.0 for kind in ("standing", "pushed"))
    return {
        "joints": found["joints"],
        **{kind: f"{found[kind]:+.1f} mm, {found[f'tilt_{kind}']:.1f} degrees" for kind in ("standing", "pushed")},
        "result": "in bounds" if good else "out of bounds",
    }


def _figures(module: str, arguments: list[str], log: Path) -> dict[str, Any]:
    """Run a module of this folder; return what it prints, or a result that says why it does not."""
    command = [sys.executable, "-m", f"tests.bench.{module}", *arguments]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=LIMIT, check=False)
    log.write_text(done.stdout + done.stderr)
    if done.returncode:
        return {"result": f"not measured: {done.stderr.strip().splitlines()[-1]}"}
    found = json.loads(done.stdout)
    assert isinstance(found, dict)
    return found


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


BASES = {
    "robot": "robot",
    "kinematics": "kinematics",
    "straight": "straight, %",
    "turn": "turn, %",
    "sideways": "sideways, %",
    "odometry": "odometry error",
    "check": "`check --strict`",
    "result": "within 2 % straight, 3 % otherwise",
    "seconds": "import and test, s",
}
ARMS = {
    "robot": "robot",
    "joints": "joints",
    "hold": "hold, mrad",
    "points": "trajectory, mrad",
    "end": "end of trajectory, mrad",
    "hold_payload": "hold with 1 kg, mrad",
    "points_payload": "trajectory with 1 kg, mrad",
    "goals": "other goals passed",
    "check": "`check --strict`",
    "result": "within 1 (hold), 5 (trajectory), 1 (end), 10 mrad (trajectory with 1 kg)",
    "seconds": "import and test, s",
}
LEGS = {
    "robot": "robot",
    "joints": "joints",
    "standing": "after 10 s: change of height, tilt",
    "pushed": "10 s after a push of 50 N for 0.1 s",
    "check": "`check --strict`",
    "result": "within 20 mm, 20 degrees",
    "seconds": "import and test, s",
}
TABLES = {"base": BASES, "arm": ARMS, "legs": LEGS}


def table(columns: dict[str, str], rows: list[dict[str, Any]]) -> str:
    """Return rows as a Markdown table."""
    lines = ["| " + " | ".join(columns.values()) + " |", "|" + "---|" * len(columns)]
    lines += ["| " + " | ".join(str(row.get(column, "-")) for column in columns) + " |" for row in rows]
    return "\n".join(lines)


def main() -> None:
    """Measure the robots and print, or write, the tables."""
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
    of_kind = {kind: [row[kind] for row in rows if kind in row] for kind in TABLES}
    text = "\n\n".join(table(TABLES[kind], found) for kind, found in of_kind.items() if found)
    print(text)
    if given.write:
        page = PAGE.read_text(encoding="utf-8")
        head, tail = page.partition(BEGIN)[0], page.partition(END)[2]
        PAGE.write_text(f"{head}{BEGIN}\n\n{text}\n\n{END}{tail}", encoding="utf-8")


if __name__ == "__main__":
    main()
