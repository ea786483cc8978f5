"""Values that wires may carry to a node: odd ones of every type, and legal ones."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from hypothesis import strategies as st

from graphengine.node.port import Port
from graphengine.node.types import PortType, coerce
from tests.nodes.test_ports import TYPES
from tests.nodes.trial import Trial

_REALS = [math.nan, math.inf, -math.inf, 1e308, -1e308, 5e-324, 0.0, -0.0, 1.0, -1.0, 0.5, 90.0, 2.0**31, 1e16, 1e-300]
_TEXTS = [
    "",
    "a",
    "a\0b",
    "/",
    "/robot",
    "/nowhere",
    "left",
    "nothing",
    "{",
    "[]",
    '{"1": 2}',
    "1e999",
    "ü\U0001f600",
    " ",
]
_LIMITS = {"uchar": (0, 2**8 - 1), "int": (-(2**31), 2**31 - 1), "uint": (0, 2**32 - 1), "int64": (-(2**63), 2**63 - 1)}
_LIMITS["uint64"] = (0, 2**64 - 1)


def values_of(port_type: PortType, tokens: tuple[str, ...] = ()) -> st.SearchStrategy[Any]:
    """Values that a wire of a type may carry, the odd ones first."""
    if port_type.role == "pointer":
        return st.sampled_from(
            [0, b"", b"abc", bytes(12), np.arange(12, dtype=np.float32), np.full(3, np.nan, np.float32)]
        )
    if port_type.base == "target":
        return st.lists(st.sampled_from(_TEXTS[3:8]), max_size=4).map(tuple)
    if port_type.base in ("any", "bundle"):
        return st.one_of(
            *(values_of(PortType(base, 1, array)) for base in ("double", "int", "token") for array in (False, True))
        )
    one = _scalars(port_type.base, tokens)
    if port_type.count > 1:
        one = st.tuples(*[one] * port_type.count)
    if not port_type.array:
        return one
    many = st.sampled_from([0, 1, 2, 3, 4, 8, 9, 12, 16]).flatmap(
        lambda size: st.lists(one, min_size=size, max_size=size)
    )
    if not port_type.is_number:
        return many.map(tuple)
    shape = (-1,) if port_type.count == 1 else (-1, port_type.count)
    with_limits = port_type.dtype

    def packed(items: list[Any]) -> Any:
        with np.errstate(all="ignore"):
            return np.array(items, with_limits).reshape(shape)

    return many.map(packed)


def _scalars(base: str, tokens: tuple[str, ...]) -> st.SearchStrategy[Any]:
    if base == "bool":
        return st.booleans()
    if base in _LIMITS:
        low, high = _LIMITS[base]
        return st.sampled_from([n for n in (low, high, -1, 0, 1, 2, 7, 10**8) if low <= n <= high]) | st.integers(
            low, high
        )
    if base in ("double", "float", "half", "timecode"):
        return st.sampled_from(_REALS) | st.floats()
    return st.sampled_from([*tokens[:6], *_TEXTS]) | st.text(st.characters(exclude_categories=["Cs"]), max_size=20)


def bad_inputs(trial: Trial) -> st.SearchStrategy[dict[str, Any]]:
    """Values for some of a node's inputs that wires may lead to."""
    if not trial.wired:
        return st.just({})
    return st.fixed_dictionaries(
        {}, optional={port.field: values_of(trial.types[port.field], port.tokens) for port in trial.wired}
    )


_SIZE = st.floats(0.01, 10.0)
_CLOUD = "isaacsim.ros2.bridge.ROS2PublishPointCloud"
LEGAL: dict[str, dict[str, st.SearchStrategy[Any] | None]] = {
    "WhileLoop": {"condition": None},
    "AckermannController": {
        **dict.fromkeys(("wheel_base", "front_wheel_radius", "back_wheel_radius"), _SIZE),
        **dict.fromkeys(("acceleration", "steering_angle_velocity")),
    },
    "DifferentialController": {
        **dict.fromkeys(("wheel_radius", "wheel_distance"), _SIZE),
        **dict.fromkeys(("max_acceleration", "max_deceleration", "max_angular_acceleration")),
    },
    "HolonomicController": {
        "wheel_radius": _SIZE,
        **dict.fromkeys(("wheel_positions", "wheel_orientations", "mecanum_angles", "wheel_axis", "up_axis")),
    },
    "QuinticPathPlanner": {
        **dict.fromkeys(("current_position", "target_position"), st.floats(-100.0, 100.0)),
        **dict.fromkeys(("initial_velocity", "goal_velocity"), st.floats(0.0, 0.5)),
        **dict.fromkeys(("initial_accel", "goal_accel"), st.floats(-0.1, 0.1)),
        "max_accel": st.floats(1.5, 1000.0),
        "max_jerk": st.floats(0.3, 1000.0),
    },
    "StanleyControlPID": {"wheel_base": _SIZE, "step": _SIZE, "gains": None, "path_arrays": None},
    "OgnROS2ServiceServerResponse": {"server_handle": None},
    "ROS2PublishLaserScan": {"num_rows": None, "num_cols": None},
    "Clamp": {"lower": st.floats(-1000.0, 0.0), "upper": st.floats(2.0, 1000.0)},
    **{name: {"index": st.integers(-1, 0)} for name in ("ArrayIndex", "ArrayRemoveIndex", "ArraySetIndex")},
    **{name: {"index": st.integers(-9, 8)} for name in ("GetString", "RemoveString")},
    "Divide": {"b": st.floats(-1000.0, -0.001) | st.floats(0.001, 1000.0)},
    "Logarithm": {"base": st.floats(1.5, 1000.0), "value": st.floats(0.001, 1000.0)},
    "RandomGaussian": {"stdev": st.floats(0.0, 1000.0)},
    "RandomNumeric": {"minimum": st.floats(-1000.0, 0.0), "maximum": st.floats(1.0, 1000.0)},
    "ROS2PublishOdometry": {"robot_front": st.floats(0.1, 1000.0)},
    "ROS2PublishPointCloud": {f: None for f in TYPES[_CLOUD].fields if f.startswith("output_")},
}
"""Legal numbers of inputs that take less than their ports declare; None where the good value alone is tried."""


def legal_inputs(trial: Trial) -> st.SearchStrategy[dict[str, Any]]:
    """A finite value, within what the port declares, for one of the inputs that wires may lead to."""
    domains = LEGAL.get(TYPES[trial.cls.type_name].__name__, {})
    ports = [port for port in trial.wired if domains.get(port.field, st.none()) is not None]
    return st.one_of(
        *(st.fixed_dictionaries({p.field: _legal(trial, p, domains.get(p.field))}) for p in ports)
    ) | st.just({})


def _legal(trial: Trial, port: Port, domain: st.SearchStrategy[Any] | None) -> st.SearchStrategy[Any]:
    """Legal values of one input; arrays are as long as the good one."""
    kind = trial.types[port.field]
    if port.tokens:
        return st.sampled_from([token for token in port.tokens if token != "unknown"])
    if not kind.is_number or kind.role == "pointer":
        return st.just(trial.good[port.field])
    bound = port.ge if port.ge is not None else port.gt
    low, high = _LIMITS.get(kind.base, (-1000, 1000))
    low, high = max(low, -1000 if bound is None else math.ceil(bound)), min(high, 1000)
    one: st.SearchStrategy[Any] = st.booleans() if kind.base == "bool" else st.integers(low, high)
    if kind.base in ("double", "float", "half", "timecode"):
        one = st.floats(low, high, exclude_min=port.gt is not None, allow_subnormal=False)
    one = one if domain is None else domain
    if kind.count > 1:
        one = st.tuples(*[one] * kind.count)
    if not kind.array:
        return one
    size = len(trial.good[port.field])
    return st.lists(one, min_size=size, max_size=size).map(lambda items: coerce(items, kind))
