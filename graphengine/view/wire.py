"""Messages that a run sends to the process of its page. The process sends JSON to the run: `{"viewer": 0, "ask": …}`."""

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
    """Scene data that change only when robots are added or removed, or files are reloaded.

    Attributes:
        title: name of the scene.
        bodies: visible bodies.
        graphs: name, robot, prim path, file and variables of each graph in execution order, as JSON values.
        drives: drive topics by robot name.
        layers: data of the 3D part's layers.
        focus: point at which cameras initially look, m.
        robots: name, prim path, namespace, file and sensors of each robot, as JSON values.
        definitions: message types.
        topics: names of the topics that nodes publish or receive.
        objects: names of the objects that can be moved.
        keys: whether a node reads the keyboard.
    """

    title: str
    bodies: Bodies
    graphs: Sequence[Mapping[str, Any]]
    drives: Mapping[str, str]
    layers: SceneLayers
    focus: tuple[float, float, float]
    robots: Sequence[Mapping[str, Any]] = ()
    definitions: Definitions = DEFINITIONS
    topics: Sequence[str] = ()
    objects: Sequence[str] = ()
    keys: bool = False


@dataclass(frozen=True, slots=True)
class GraphDetails:
    """Details of the graph that a viewer selected.

    Attributes:
        viewer: number of the viewer.
        name: name of the graph, such as `robot/graph`.
        view: data for drawing the graph, or the reason why the graph cannot be drawn.
        nodes: details of nodes and their ports, by node name.
    """

    viewer: int
    name: str
    view: GraphView | str
    nodes: Mapping[str, Mapping[str, Any]]


@dataclass(frozen=True, slots=True)
class LiveState:
    """The state of a run after a tick.

    Attributes:
        facts: fields of a `RunStatus` as JSON values.
        poses: position (m) and quaternion (x, y, z, w) of each body, shape (bodies, 7).
        layers: data of the shown layers of the 3D part.
        values: short values of ports and variables, by selected graph, then by `Node.side:port` or `variable:name`.
        nodes: executions, firings, microseconds per execution and place in the order of execution since the last frame in which
            ticks ran, by selected graph, then by node.
        robots: pose and velocity of the selected robots, by name.
    """

    facts: Mapping[str, Any]
    poses: NDArray[np.float64]
    layers: FrameLayers = field(default_factory=FrameLayers)
    values: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    nodes: Mapping[str, Mapping[str, tuple[int, int, float, int]]] = field(default_factory=dict)
    robots: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class PaneContent:
    """New content of a pane of the page; it replaces the previous content.

    Attributes:
        kind: kind of the pane, such as `topics`.
        content: content as JSON values.
    """

    kind: str
    content: Any


@dataclass(frozen=True, slots=True)
class PlotSamples:
    """Samples of the expressions that viewers plot; unlike frames, none may be left out.

    Attributes:
        times: times of the samples, s; a time before the previous one begins the plots again.
        values: values by expression, one for each time; None without a value.
    """

    times: Sequence[float]
    values: Mapping[str, Sequence[float | None]]


@dataclass(frozen=True, slots=True)
class LogMessages:
    """Messages that were logged since the last ones; `lines` are the fields of each `LogLine`."""

    lines: Sequence[Mapping[str, Any]]


@dataclass(frozen=True, slots=True)
class CameraImage:
    """A new image of a camera that viewers look at.

    Attributes:
        viewers: numbers of these viewers.
        camera: prim path of the camera.
        pixels: colours, shape (height, width, 3), or distances, m, shape (height, width); None if rendering failed.
        error: why there is no image.
    """

    viewers: Sequence[int]
    camera: str
    pixels: NDArray[Any] | None
    error: str = ""


@dataclass(frozen=True, slots=True)
class TopicMessage:
    """The newest message of a topic that a viewer selected.

    Attributes:
        topic: full name of the topic.
        type: message type, such as `nav_msgs/msg/Odometry`.
        size: size of the message, bytes.
        data: CDR message; None before the first message, and if the message is too large to show.
    """

    topic: str
    type: str
    size: int
    data: bytes | None


@dataclass(frozen=True, slots=True)
class Answer:
    """The response to a request of a viewer.

    Attributes:
        viewer: number of the viewer that sent the request.
        told: `result` or `error`, and the `id` of the request, as JSON values.
    """

    viewer: int
    told: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Ended:
    """The end of the run; the last message to the page.

    Attributes:
        error: text of the error that ended the run; empty without an error.
    """

    error: str
