"""Runs OmniGraph-style ActionGraphs, written in YAML, with MuJoCo physics, and connects them to ROS 2.

    import graphengine as ge

    with ge.load("dd100_warehouse").session() as sim:
        odom = sim.subscribe("/dd100_0000/odom")
        sim.publish("/dd100_0000/cmd_vel", {"linear": {"x": 0.5}}, every=0.1)
        sim.run(5.0)
        print(odom.latest.pose.pose.position)

`load` returns a checked `Scene`; `Scene.session` starts a simulation of it.
"""

from __future__ import annotations

from graphengine.format.version import __version__ as __version__

TYPE_CHECKING = False  # the name that type checkers know; `typing` takes longer to import than all else here
if TYPE_CHECKING:
    from graphengine.api import gym as gym
    from graphengine.api.bodies import Body as Body
    from graphengine.api.bodies import Pose as Pose
    from graphengine.api.bodies import Velocity as Velocity
    from graphengine.api.expectations.bags import judge_bag as judge_bag
    from graphengine.api.expectations.expectations import always as always
    from graphengine.api.expectations.expectations import count as count
    from graphengine.api.expectations.expectations import holds as holds
    from graphengine.api.expectations.expectations import latency as latency
    from graphengine.api.expectations.expectations import never as never
    from graphengine.api.expectations.expectations import rate as rate
    from graphengine.api.expectations.expectations import settles as settles
    from graphengine.api.expectations.expectations import until as until
    from graphengine.api.expectations.expectations import within as within
    from graphengine.api.expectations.metrics import metric as metric
    from graphengine.api.mujoco_objects import MujocoObjects as MujocoObjects
    from graphengine.api.robots import Joint as Joint
    from graphengine.api.robots import Robot as Robot
    from graphengine.api.scene import GraphInfo as GraphInfo
    from graphengine.api.scene import RobotInfo as RobotInfo
    from graphengine.api.scene import Scene as Scene
    from graphengine.api.scene_loading import load as load
    from graphengine.api.sensors import RobotSensor as RobotSensor
    from graphengine.api.session import Session as Session
    from graphengine.api.session_control import Checkpoint as Checkpoint
    from graphengine.api.topics import Publication as Publication
    from graphengine.api.topics import Subscription as Subscription
    from graphengine.api.value_records import ValueRecord as ValueRecord
    from graphengine.format.diagnostics import CheckError as CheckError
    from graphengine.format.errors import ExpectationError as ExpectationError
    from graphengine.format.errors import GraphError as GraphError
    from graphengine.format.errors import NodeError as NodeError
    from graphengine.format.errors import PhysicsError as PhysicsError
    from graphengine.format.errors import RecordingError as RecordingError
    from graphengine.format.errors import RenderError as RenderError
    from graphengine.format.errors import StateError as StateError
    from graphengine.format.errors import TransportError as TransportError
    from graphengine.format.errors import UnknownEntityError as UnknownEntityError
    from graphengine.format.errors import UsageError as UsageError
    from graphengine.runtime.reloading import Reloaded as Reloaded
    from graphengine.runtime.why.explanation import Explanation as Explanation

_MODULES = {
    "api.scene_loading": ("load",),
    "api.scene": ("Scene", "GraphInfo", "RobotInfo"),
    "api.session": ("Session",),
    "api.session_control": ("Checkpoint",),
    "api.topics": ("Subscription", "Publication"),
    "api.value_records": ("ValueRecord",),
    "api.mujoco_objects": ("MujocoObjects",),
    "api.bodies": ("Body", "Pose", "Velocity"),
    "api.robots": ("Robot", "Joint"),
    "api.sensors": ("RobotSensor",),
    "api.gym": ("gym",),
    "api.expectations.bags": ("judge_bag",),
    "api.expectations.expectations": (
        "always",
        "count",
        "holds",
        "latency",
        "never",
        "rate",
        "settles",
        "until",
        "within",
    ),
    "api.expectations.metrics": ("metric",),
    "runtime.reloading": ("Reloaded",),
    "runtime.why.explanation": ("Explanation",),
    "format.errors": (
        "ExpectationError",
        "GraphError",
        "NodeError",
        "PhysicsError",
        "RecordingError",
        "RenderError",
        "StateError",
        "TransportError",
        "UnknownEntityError",
        "UsageError",
    ),
    "format.diagnostics": ("CheckError",),
}
_ORIGINS = {name: f"{__name__}.{module}" for module, names in _MODULES.items() for name in names}

__all__ = [*_ORIGINS, "__version__"]

if not TYPE_CHECKING:  # so that a misspelt name is an error to mypy and pyright

    def __getattr__(name: str) -> object:
        """Import a public name of the package when it is first used, and return its object."""
        if name not in _ORIGINS:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        import importlib

        module = importlib.import_module(_ORIGINS[name])
        globals()[name] = found = module if module.__name__.endswith(f".{name}") else getattr(module, name)
        return found


def __dir__() -> list[str]:
    return __all__
