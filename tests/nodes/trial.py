"""Any built-in node alone in surroundings that it can work in, fed with values of its inputs' types as wires bring them."""

from __future__ import annotations

import itertools
import json
import math
from collections import deque
from collections.abc import Iterator, Mapping
from typing import Annotated, Any

import numpy as np

from graphengine.compiler.registry import Registry, default_registry
from graphengine.messages.definitions import DEFINITIONS
from graphengine.node import BadValueError, ExecIn, ExecOut, In, Node, Out
from graphengine.node.node_class import NodeMeta, grown
from graphengine.node.port import Port, camel_case
from graphengine.node.types import PortType, UnionType, coerce, first_that_takes
from graphengine.scene.loaded_scene import Options
from tests.nodes.harness import Player, Playing
from tests.nodes.test_ports import NEEDED, TYPES, surroundings

ROUNDS = 50
"""Of a loop, in these trials."""


BOUND = {"selection", "selected"}
"""State that depends on the inputs of a tick alone, and is bound anew when they change."""
ALSO = {"ROS2PublishLaserScan": {"num_rows": 1, "num_cols": 2, "linear_depth_data": [1.0, 2.0]}}
"""Inputs with which nodes have something to do that can do without."""


class Trial:
    """A node of a type, set up, with types of its ports as a graph settles them.

    Args:
        name: registered type.
        arrays: whether inputs that take arrays too are given arrays.

    Raises:
        ValueError: inputs of such types do not go together.
    """

    def __init__(self, name: str, *, arrays: bool = False) -> None:
        plain = TYPES[name]
        needed = NEEDED.get(plain.__name__, {}) or ALSO.get(plain.__name__, {})
        literals = {plain.fields[field].name: value for field, value in needed.items() if field in plain.fields}
        self.cls = grown(plain, literals, DEFINITIONS)
        self.good: dict[str, Any] = {}
        self.types: dict[str, PortType] = {}
        for port in inputs_of(self.cls):
            value = needed.get(port.field, port.default)
            if isinstance(port.type, PortType):
                self.types[port.field], self.good[port.field] = port.type, coerce(value, port.type)
                continue
            kind, value = first_that_takes(value, port.type.alternatives)
            array = PortType(kind.base, kind.count, True, kind.role)
            if arrays and not kind.array and array in port.type.alternatives:
                kind, value = array, coerce([value, value], array)
            self.types[port.field], self.good[port.field] = kind, value
        self.context = surroundings()
        self.context.runs = "physics_step" if name.endswith("OnPhysicsStep") else "tick"
        self.context.world.add_body("/World/box")
        self.context.service_server("std_srvs/srv/SetBool", "/served")
        self.context.action_server("example_interfaces/action/Fibonacci", "/pursued")
        self.node: Any = self.cls(**{f: v for f, v in self.good.items() if not self.cls.fields[f].unset})
        unions = {p.field for p in inputs_of(self.cls) if isinstance(p.type, UnionType)}
        known = {field: kind for field, kind in self.types.items() if field in unions}
        types = {field: kind for field, kind in self.types.items() if kind.base != "any"}
        self.node.settled = {**known, **self.node.resolve_types(types, {"speed": PortType("double")})}
        self.types |= {field: kind for field, kind in self.node.settled.items() if field in self.types}
        self.node.clear()
        self.node.setup(self.context)
        self.wired = [port for port in inputs_of(self.cls) if not port.setup and port.type != PortType("bundle")]

    def tick(self, values: Mapping[str, Any] | None = None, *, execute: bool = True) -> BadValueError | None:
        """Begin a tick and execute the node with these inputs, the others good; the refusal, if it refuses."""
        self.context.tick()
        node = self.node
        for field, value in {**self.good, **(values or {})}.items():
            setattr(node, field, value)
        if not execute:
            return None
        for port in self.cls.fields.values():
            if port.is_exec and port.side == "inputs":
                setattr(node, port.field, int(not port.control))
        try:
            found = node.compute()
            if self.cls.kind() == "pusher":
                deque(itertools.islice(found, 2 * ROUNDS), maxlen=0)
        except BadValueError as refusal:
            return refusal
        return None

    def update(self) -> BadValueError | None:
        """What a latent node does in the rest of a tick."""
        try:
            if self.cls.kind() == "latent" and self.node.active:
                self.node.update()
        except BadValueError as refusal:
            return refusal
        return None

    def seen(self) -> dict[str, Any]:
        """Outputs, State and all that the node can change, in a form that compares."""
        fields = [p.field for p in self.cls.fields.values() if not p.is_exec and p.side != "inputs"]
        fields = [field for field in fields if field not in BOUND and hasattr(self.node, field)]
        found = {field: frozen(getattr(self.node, field)) for field in fields}
        robot = self.context.world.articulation(self.context.world.stage.find("/robot"))
        found["robot"] = frozen(robot.targets)
        found["pose"] = frozen(self.context.world.body(self.context.world.stage.find("/robot")).pose())
        found["variable"] = frozen(self.context.variables["speed"].value)
        return found

    def sent(self) -> int:
        """How many messages the node sent."""
        claims = self.context.services.claims
        return sum(len(self.context.transport.raw(claim.topic)) for claim in claims)


def inputs_of(cls: type[Node]) -> list[Port]:
    return [port for port in cls.fields.values() if port.side == "inputs" and not port.is_exec]


def trials(name: str) -> Iterator[Trial]:
    """The node with single values, and with arrays where these go together."""
    yield Trial(name)
    try:
        other = Trial(name, arrays=True)
    except ValueError:
        return
    if any(other.types[field] != kind for field, kind in Trial(name).types.items()):
        yield other


def frozen(value: Any) -> Any:
    """A value in a form that compares; handles of the world are all the same."""
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, np.random.Generator):
        return repr(value.bit_generator.state)
    if isinstance(value, Mapping):
        return {key: frozen(item) for key, item in value.items() if key != "__builtins__"}
    if isinstance(value, tuple | list | deque):
        return tuple(map(frozen, value))
    return repr(value) if isinstance(value, str | int | float | bool | None) else type(value).__name__


def spoiled(value: Any) -> bool:
    """Whether a number in a value is not finite."""
    if isinstance(value, np.ndarray):
        return value.dtype.kind == "f" and not np.isfinite(value).all()
    if isinstance(value, tuple | list | deque):
        return any(map(spoiled, value))
    return isinstance(value, float) and not math.isfinite(value)


class Sink(Node, type="tests.Sink"):
    """Reads whatever a data node gives."""

    exec_in = ExecIn()
    value: Any = In(doc="anything")

    def compute(self) -> None:
        """Read it."""


def play_wired(play: Player, trial: Trial) -> tuple[Playing, Any]:
    """A graph in which wires lead to all inputs of a trial's node that one may lead to, and what stands at their other ends."""
    plain, fields = TYPES[trial.cls.type_name], {port.field: port for port in trial.wired}
    first = {**trial.good, "server_handle": 0}  # there is no server before the first tick
    outputs: dict[str, Any] = {f"out_{field}": Out(default=first[field], doc="fed") for field in fields}
    hints = {f"out_{field}": Annotated[Any, trial.types[field]] for field in fields}
    body = {"__annotations__": hints, "__doc__": "Feeds values.", "exec_in": ExecIn(), "exec_out": ExecOut(), **outputs}
    source = NodeMeta("Source", (Node,), body, type="tests.Source")
    known = default_registry()
    registry = Registry(dict(known.types), dict(known.short_names), dict(known.owners))
    for cls in (source, Sink):
        registry.add(cls)  # type: ignore[arg-type]
    needed = NEEDED.get(plain.__name__, {})
    literals = {p.name: needed[p.field] for p in inputs_of(trial.cls) if p.field in needed and p.field not in fields}
    wires = ["Tick.tick -> Source.execIn", "Source.execOut -> Sink.execIn"]
    pins = [p.name for p in trial.cls.fields.values() if p.is_exec and p.side == "inputs" and not p.control]
    wires += [f"Source.execOut -> Node.{pin}" for pin in pins]
    wires += [f"Source.{camel_case(f'out_{field}')} -> Node.inputs:{port.name}" for field, port in fields.items()]
    if trial.cls.kind() == "data":
        outs = [port.name for port in trial.cls.fields.values() if port.side == "outputs"] or ["inputs:value"]
        wires.append(f"Node.{outs[0]} -> Sink.value")
    text = f"""
variables: {{speed: {{type: double, default: 1.0}}}}
nodes:
  Tick: OnPlaybackTick
  Source: tests.Source
  Sink: tests.Sink
  Node: {{type: {trial.cls.type_name}, inputs: {json.dumps(literals, default=list)}}}
connections: {json.dumps(wires)}
"""
    playing = play.graph(text, trial.context.world, options=Options(registry=registry, scripts=True))
    return playing, playing.node("Source")
