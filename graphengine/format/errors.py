"""The exception tree.

GraphError                  base of all exceptions of this package
├── BadValueError           a wire's value that a node cannot use; the run continues
├── CheckError              errors in the files of a graph or scene
├── ContextError            a node requested something missing or illegal from its context
│   ├── PrimError           no prim at a path, or a prim of the wrong kind
│   │   └── AmbiguousPrimError   a path that could mean several prims
│   ├── JointError          no such joint
│   ├── TopicError          a topic, namespace or QoS profile that is not legal in ROS 2
│   ├── MessageTypeError    an unknown or unusable message type (in messages/interfaces.py)
│   └── MissingMessageError a generic node without a message type (in nodes/ros2/fields.py)
├── ControlError            a running session could not be reached, or refused a command
├── NodeClassError          a node class that cannot be registered (in node/node_class.py)
├── NodeError               an exception in a node's `compute`
├── PhysicsError            the simulation diverged
├── RecordingError          a recording that cannot be written or read
├── RenderError             pictures cannot be drawn
├── TrajectoryError         a trajectory that is invalid for the joints (in nodes/ros2/joint_trajectory.py)
├── TransportError          the network could not be joined, or a peer's library failed
│   └── MessageError        a message that does not match its type (in messages/messages.py)
└── UsageError              invalid arguments (exit code 2 of `graphrun`)
    ├── NoObstaclesError    an occupancy map without bounds of a world without obstacles (in physics/occupancy/occupancy_map.py)
    ├── RefusedError        a refused request of simulation_interfaces (in control/simulation_interfaces/results.py)
    ├── StateError          a call that the state of the session does not allow
    └── UnknownEntityError  no robot or object has the name
"""

from __future__ import annotations

import reprlib
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from graphengine.format.diagnostics import Finding


class GraphError(Exception):
    """Base of all exceptions of this package."""


class BadValueError(GraphError, ValueError):
    """A value from a wire that a node cannot use.

    The node's branch ends for this tick and the run continues. A node raises it before it changes outputs, state or the world.

    Args:
        port: OmniGraph name of the input, for example `velocityCommand`, or of several with incompatible values: `a, b`.
        value: the value of the port.
        legal: the values that the node can use, to follow "must be"; empty if the port's name says enough.
    """

    def __init__(self, port: str, value: object, legal: str = "") -> None:
        text = " ".join(reprlib.repr(value).split())
        super().__init__(f"{port} must be {legal}, it is {text}" if legal else f"{port} cannot be {text}")
        self.port = port
        self.value = value

    def __str__(self) -> str:
        text = super().__str__()
        return f"{text}: {self.__cause__}" if self.__cause__ is not None else text


class CheckError(GraphError):
    """Errors in the files of a graph or scene."""

    def __init__(self, findings: Sequence[Finding]) -> None:
        super().__init__("\n".join(finding.render() for finding in findings))
        self.findings = tuple(findings)


class ContextError(GraphError):
    """A node requested something missing or illegal from its context.

    Args:
        message: the problem.
        value: value of the input that caused the problem; the finding points to this input in the file.
        help: lines on legal values and remedies.
    """

    code = "G307"

    def __init__(self, message: str, value: object = None, *help: str) -> None:
        self.message = message
        self.value = value
        self.help = tuple(filter(None, help))
        super().__init__("\n".join((message, *self.help)))


class PrimError(ContextError):
    """No prim has the path, or the prim is of the wrong kind."""

    code = "G301"


class AmbiguousPrimError(PrimError):
    """A path that could mean several prims."""

    code = "G302"


class JointError(ContextError):
    """The robot has no joint with the name or index."""

    code = "G303"


class TopicError(ContextError):
    """A topic, namespace or QoS profile that is not legal in ROS 2."""

    code = "G304"


class ControlError(GraphError):
    """A running session could not be reached, or refused a command."""


class NodeError(GraphError):
    """An exception in a node's `compute`, which is chained as the cause.

    Args:
        message: the problem, its place and the inputs of the node.
        node: prim path of the node; empty if the error belongs to none.
    """

    def __init__(self, message: str, node: str = "") -> None:
        super().__init__(message)
        self.node = node


class PhysicsError(GraphError):
    """The simulation diverged."""


class RecordingError(GraphError):
    """A recording cannot be written or read."""


class RenderError(GraphError):
    """Pictures cannot be rendered: OpenGL is missing or failed."""


class TransportError(GraphError):
    """The network could not be joined, or a peer's library failed."""


class UsageError(GraphError):
    """Invalid arguments of a command line or a call."""


class StateError(UsageError):
    """The state of the session does not allow the call."""


class UnknownEntityError(UsageError):
    """No robot or object has the name."""
