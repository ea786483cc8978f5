"""Public descriptions of robots that tests/bench/public_robots.py imports and measures."""

from __future__ import annotations

from dataclasses import dataclass, field


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
