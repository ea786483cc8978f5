"""What a run tells the process of its page. What that tells the run is JSON: `{"viewer": 0, "ask": "command", ...}`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.rotation import Pose
from graphengine.devices.visible import Bodies


@dataclass(frozen=True, slots=True)
class GraphDrawing:
    """A graph of the run.

    Attributes:
        name: `robot/graph`.
        svg: its drawing, of which each node carries its name; empty without the layout library.
        nodes: its nodes by name, with what the page tells of their ports.
        file: its file.
    """

    name: str
    svg: str
    nodes: Mapping[str, Mapping[str, Any]]
    file: str


@dataclass(frozen=True, slots=True)
class LiveScene:
    """What changes only when robots come or go.

    Attributes:
        title: name of the scene.
        bodies: what is visible.
        graphs: in the order they run.
        drives: topic by which each robot is driven, of those that have one.
        beams: unit vectors of each lidar's beams in its own frame, shape (beams, 3), by prim path.
        focus: place that the camera looks at first, m.
    """

    title: str
    bodies: Bodies
    graphs: Sequence[GraphDrawing]
    drives: Mapping[str, str]
    beams: Mapping[str, NDArray[np.float32]]
    focus: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class LiveState:
    """The state of a run after a tick.

    Attributes:
        facts: time, state, rate and counters, as JSON has them.
        poses: of all bodies, shape (bodies, 7).
        scans: pose and distances (m, inf without a hit) of each lidar with a new sample, if that layer is shown.
        values: text of each port, by `graph`, then `Node.port`, of the graphs that are looked at.
        nodes: runs, firings and microseconds of a run since the last frame, by graph and node, likewise.
    """

    facts: Mapping[str, Any]
    poses: NDArray[np.float64]
    scans: Mapping[str, tuple[Pose, NDArray[np.float32]]] = field(default_factory=dict)
    values: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    nodes: Mapping[str, Mapping[str, tuple[int, int, float]]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class LiveMarks:
    """The events of a recording, each with its tick, kind and text."""

    marks: Sequence[Mapping[str, Any]]


@dataclass(frozen=True, slots=True)
class Answer:
    """What became of a command.

    Attributes:
        viewer: number of who asked.
        told: result or error, as JSON has them.
    """

    viewer: int
    told: Mapping[str, Any]
