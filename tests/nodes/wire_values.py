"""Values that wires may carry to a node: odd ones of every type, and legal ones."""

from __future__ import annotations

import math
import struct
from random import Random
from typing import Any

import numpy as np

from graphengine.node.port import Port
from graphengine.node.types import PortType, coerce
from tests.nodes.test_ports import TYPES
from tests.nodes.trial import Trial

_REALS = [math.nan, math.inf, -math.inf, 1e308, -1e308, 5e-324, 0.0, -0.0, 1.0, -1.0, 0.5, 90.0, 2.0**31, 1e16, 1e-300]
_TEXTS = ["", "a", "a\0b", "/", "/robot", "/nowhere", "left", "nothing"]
_TEXTS += ["{", "[]", '{"1": 2}', "1e999", "ü\U0001f600", " "]
_LIMITS = {"uchar": (0, 2**8 - 1), "int": (-(2**31), 2**31 - 1), "uint": (0, 2**32 - 1), "int64": (-(2**63), 2**63 - 1)}
_LIMITS["uint64"] = (0, 2**64 - 1)


def a_value(random: Random, port_type: PortType, tokens: tuple[str, ...] = ()) -> Any:
    """A value that a wire of a type may carry, often an odd one."""
    if port_type.role == "pointer":
        return random.choice(
            [0, b"", b"abc", bytes(12), np.arange(12, dtype=np.float32), np.full(3, np.nan, np.float32)]
        )
    if port_type.base == "target":
        return tuple(random.choices(_TEXTS[3:8], k=random.randint(0, 4)))
    if port_type.base in ("any", "bundle"):
        base, array = random.choice(["double", "int", "token"]), random.choice([False, True])
        return a_value(random, PortType(base, 1, array))
    one = _a_component if port_type.count == 1 else _a_tuple
    if not port_type.array:
        return one(random, port_type, tokens)
    many = [one(random, port_type, tokens) for _ in range(random.choice([0, 1, 2, 3, 4, 8, 9, 12, 16]))]
    if not port_type.is_number:
        return tuple(many)
    with np.errstate(all="ignore"):
        return np.array(many, port_type.dtype).reshape((-1,) if port_type.count == 1 else (-1, port_type.count))


def _a_tuple(random: Random, port_type: PortType, tokens: tuple[str, ...]) -> Any:
    return tuple(_a_component(random, port_type, tokens) for _ in range(port_type.count))


def _a_component(random: Random, port_type: PortType, tokens: tuple[str, ...]) -> Any:
    base, odd = port_type.base, random.random() < 0.5
    if base == "bool":
        return odd
    if base in _LIMITS:
        low, high = _LIMITS[base]
        known = [n for n in (low, high, -1, 0, 1, 2, 7, 10**8) if low <= n <= high]
        return random.choice(known) if odd else random.randint(low, high)
    if base in ("double", "float", "half", "timecode"):
        if odd:
            return random.choice(_REALS)
        (bits,) = struct.unpack("d", random.randbytes(8))
        return random.choice([bits, random.uniform(-1000.0, 1000.0)])
    if odd or tokens:
        return random.choice([*tokens[:6], *_TEXTS])
    points = (random.choice([random.randrange(0x80), random.randrange(0xE000, 0x110000)]) for _ in range(20))
    return "".join(map(chr, points))[: random.randint(0, 20)]


def bad_inputs(random: Random, trial: Trial) -> dict[str, Any]:
    """Values for some of a node's inputs that wires may lead to."""
    ports = [port for port in trial.wired if random.random() < 0.5]
    return {port.field: a_value(random, trial.types[port.field], port.tokens) for port in ports}


Range = tuple[float, float]
_SIZE = (0.01, 10.0)
_CLOUD = "isaacsim.ros2.bridge.ROS2PublishPointCloud"
LEGAL: dict[str, dict[str, Range | None]] = {
    "WhileLoop": {"condition": None},
    "AckermannController": {
        **dict.fromkeys(("wheel_base", "front_wheel_radius", "back_wheel_radius"), _SIZE),
        **dict.fromkeys(("acceleration", "steering_angle_velocity")),
    },
    "ComputeWheelOdometry": dict.fromkeys(("wheel_radius", "wheel_distance", "wheel_distance_multiplier"), _SIZE),
    "DifferentialController": {
        **dict.fromkeys(("wheel_radius", "wheel_distance"), _SIZE),
        **dict.fromkeys(("max_acceleration", "max_deceleration", "max_angular_acceleration")),
    },
    "HolonomicController": {
        "wheel_radius": _SIZE,
        **dict.fromkeys(("wheel_positions", "wheel_orientations", "mecanum_angles", "wheel_axis", "up_axis")),
    },
    "IsaacGripperController": {"gripper_speed": _SIZE},
    "QuinticPathPlanner": {
        **dict.fromkeys(("current_position", "target_position"), (-100.0, 100.0)),
        **dict.fromkeys(("initial_velocity", "goal_velocity"), (0.0, 0.5)),
        **dict.fromkeys(("initial_accel", "goal_accel"), (-0.1, 0.1)),
        "max_accel": (1.5, 1000.0),
        "max_jerk": (0.3, 1000.0),
    },
    "StanleyControlPID": {"wheel_base": _SIZE, "step": _SIZE, "gains": None, "path_arrays": None},
    "OgnROS2ServiceServerResponse": {"server_handle": None},
    "ROS2ActionServerFeedback": {"server_handle": None},
    "ROS2ActionServerResult": {"server_handle": None},
    "ROS2PublishLaserScan": {"num_rows": None, "num_cols": None},
    "Clamp": {"lower": (-1000.0, 0.0), "upper": (2.0, 1000.0)},
    **{name: {"index": (-1, 0)} for name in ("ArrayIndex", "ArrayRemoveIndex", "ArraySetIndex")},
    **{name: {"index": (-9, 8)} for name in ("GetString", "RemoveString")},
    "Divide": {"b": (0.001, 1000.0)},
    "Logarithm": {"base": (1.5, 1000.0), "value": (0.001, 1000.0)},
    "RandomGaussian": {"stdev": (0.0, 1000.0)},
    "RandomNumeric": {"minimum": (-1000.0, 0.0), "maximum": (1.0, 1000.0)},
    "ROS2PublishOdometry": {"robot_front": (0.1, 1000.0)},
    "ROS2PublishPointCloud": {f: None for f in TYPES[_CLOUD].fields if f.startswith("output_")},
}
"""Least and greatest of inputs that take less than their ports declare; None where the good value alone is tried."""


def legal_inputs(random: Random, trial: Trial) -> dict[str, Any]:
    """A finite value, within what the port declares, for one of the inputs that wires may lead to."""
    domains = LEGAL.get(TYPES[trial.cls.type_name].__name__, {})
    ports = [port for port in trial.wired if domains.get(port.field, ()) is not None]
    return {
        port.field: _legal(random, trial, port, domains.get(port.field)) for port in ports and [random.choice(ports)]
    }


def _legal(random: Random, trial: Trial, port: Port, domain: Range | None) -> Any:
    """A legal value of one input; arrays are as long as the good one."""
    kind = trial.types[port.field]
    if port.tokens:
        return random.choice([token for token in port.tokens if token != "unknown"])
    if not kind.is_number or kind.role == "pointer":
        return trial.good[port.field]
    bound = port.ge if port.ge is not None else port.gt
    least, greatest = _LIMITS.get(kind.base, (-1000, 1000))
    low, high = domain or (max(least, -1000 if bound is None else math.ceil(bound)), min(greatest, 1000))

    def number() -> Any:
        if kind.base == "bool":
            return random.choice([False, True])
        if kind.base not in ("double", "float", "half", "timecode") or isinstance(domain and domain[0], int):
            return random.randint(int(low), int(high))
        edges = [
            edge for edge in (low, high, 0.0, 1.0, 1e-9) if low <= edge <= high and (edge > low or port.gt is None)
        ]
        return float(random.choice([random.uniform(low, high), *edges]))

    def item() -> Any:
        return number() if kind.count == 1 else tuple(number() for _ in range(kind.count))

    return coerce([item() for _ in trial.good[port.field]], kind) if kind.array else item()
