"""What a run tells the process of its page. What that tells the run is JSON: `{"viewer": 0, "ask": "command", ...}`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.visible import Bodies
from graphengine.drawing.view_model import GraphView
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.view.layer_data import FrameLayers, SceneLayers


@dataclass(frozen=True, slots=True)
class LiveScene:
    """What changes only when robots come or go.

    Attributes:
        title: name of the scene.
        bodies: what is visible.
        graphs: in the order they run: name, robot, prim path, file and variables of each, as JSON has them.
        drives: topic by which each robot is driven, of those that have one.
        layers: what the layers of the 3D part show beside bodies.
        focus: place that the camera looks at first, m.
        robots: name, prim path, namespace, file and sensors of each, as JSON has them.
        definitions: message types.
    """

    title: str
    bodies: Bodies
    graphs: Sequence[Mapping[str, Any]]
    drives: Mapping[str, str]
    layers: SceneLayers
    focus: tuple[float, float, float]
    robots: Sequence[Mapping[str, Any]] = ()
    definitions: Definitions = DEFINITIONS


@dataclass(frozen=True, slots=True)
class GraphDetails:
    """A graph that a viewer looks at.

    Attributes:
        viewer: number of the viewer.
        name: `robot/graph`.
        view: what is drawn; a text if it cannot be drawn.
        nodes: its nodes by name, with what the page tells of their ports.
    """

    viewer: int
    name: str
    view: GraphView | str
    nodes: Mapping[str, Mapping[str, Any]]


@dataclass(frozen=True, slots=True)
class LiveState:
    """The state of a run after a tick.

    Attributes:
        facts: the fields of a `RunStatus`, as JSON has them.
        poses: of all bodies, shape (bodies, 7).
        layers: what the layers of the 3D part need that are shown.
        values: text of each port and variable, by `graph`, then `Node.side:port` or `variable:name`, of the graphs that are
            looked at.
        nodes: runs, firings and microseconds of a run since the last frame, by graph and node, likewise.
        robots: pose and velocity of the robots that are selected, by name.
    """

    facts: Mapping[str, Any]
    poses: NDArray[np.float64]
    layers: FrameLayers = field(default_factory=FrameLayers)
    values: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    nodes: Mapping[str, Mapping[str, tuple[int, int, float]]] = field(default_factory=dict)
    robots: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class PaneContent:
    """What a pane of the page shows, in the place of what it showed before.

    Attributes:
        kind: of the pane, such as `topics`.
        content: as JSON has it.
    """

    kind: str
    content: Any


@dataclass(frozen=True, slots=True)
class TopicMessage:
    """The newest message of a topic that a viewer looks at.

    Attributes:
        topic: full name.
        type: as in `nav_msgs/msg/Odometry`.
        size: bytes of the message.
        data: the message in CDR; None before the first one, and of one that is too large to be shown.
    """

    topic: str
    type: str
    size: int
    data: bytes | None


@dataclass(frozen=True, slots=True)
class Answer:
    """What became of a command.

    Attributes:
        viewer: number of who asked.
        told: result or error, as JSON has them.
    """

    viewer: int
    told: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Ended:
    """The end of the run: nothing follows.

    Attributes:
        error: text of the error that ended it; empty if there was none.
    """

    error: str
