"""The exception tree.

GraphError                  everything that this package raises on purpose
├── BadValueError           a value that came over a wire and that a node cannot use; the run goes on
├── CheckError              findings that keep a graph or scene from being built
├── ContextError            what a node asked for is not there, or not legal
│   ├── PrimError           no prim at that path, or one of the wrong kind
│   │   └── AmbiguousPrimError   two prims at that path
│   ├── JointError          no such joint
│   ├── TopicError          a topic, namespace or QoS profile that ROS 2 would refuse
│   ├── MessageTypeError    no such message type, or one that cannot be used (in messages/interfaces.py)
│   └── MissingMessageError a generic node whose message type is not said (in nodes/ros2/fields.py)
├── ControlError            a running session cannot be reached from outside, or refused what it was asked for
├── NodeClassError          a node class that cannot be registered (in node/node_class.py)
├── NodeError               a node raised while it computed
├── PhysicsError            the simulation diverged
├── RecordingError          a recording that cannot be written, or cannot be read
├── RenderError             pictures cannot be drawn
├── TransportError          the network could not be joined, or a peer's library failed
│   └── MessageError        a message that is not what its type says (in messages/messages.py)
└── UsageError              a command line that makes no sense (exit code 2)
    ├── RefusedError        a request of simulation_interfaces that is refused (in control/simulation_interfaces/results.py)
    ├── StateError          a session that plays, pauses or stands cannot do this then
    └── UnknownEntityError  no robot or object of that name
"""

from __future__ import annotations

import reprlib
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from graphengine.format.diagnostics import Finding


class GraphError(Exception):
    """Root of what this package raises on purpose."""


class BadValueError(GraphError, ValueError):
    """A value that came over a wire and that a node cannot use.

    The node's branch ends for this tick and the run goes on. A node raises it before it changes an output, a State or the world.

    Args:
        port: OmniGraph name of the input, for example `velocityCommand`, or of several that do not go together: `a, b`.
        value: what arrived there.
        legal: what the node can use, as the end of "… must be"; empty where the port's name says enough.
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
    """Findings that keep a graph or scene from being built."""

    def __init__(self, findings: Sequence[Finding]) -> None:
        super().__init__("\n".join(finding.render() for finding in findings))
        self.findings = tuple(findings)


class ContextError(GraphError):
    """What a node asked for in `setup` is not there, or not legal.

    Args:
        message: what is wrong.
        value: the input's value that asked for it, by which the place in the file is found.
        help: what is legal, what to do.
    """

    code = "G307"

    def __init__(self, message: str, value: object = None, *help: str) -> None:
        super().__init__("\n".join((message, *(line for line in help if line))))
        self.message = message
        self.value = value
        self.help = tuple(line for line in help if line)


class PrimError(ContextError):
    """No prim at that path, or one of the wrong kind."""

    code = "G301"


class AmbiguousPrimError(PrimError):
    """A path that could mean two prims."""

    code = "G302"


class JointError(ContextError):
    """No such joint."""

    code = "G303"


class TopicError(ContextError):
    """A topic, namespace or QoS profile that ROS 2 would refuse."""

    code = "G304"


class ControlError(GraphError):
    """A running session cannot be reached from outside, or refused what it was asked for."""


class NodeError(GraphError):
    """A node raised while it computed; the cause is chained."""


class PhysicsError(GraphError):
    """The simulation diverged."""


class RecordingError(GraphError):
    """A recording cannot be written, or a file is none that can be read."""


class RenderError(GraphError):
    """Pictures cannot be drawn: there is no OpenGL, or it refused."""


class TransportError(GraphError):
    """The network could not be joined, or a peer's library failed."""


class UsageError(GraphError):
    """A command line that makes no sense."""


class StateError(UsageError):
    """A session cannot do this while it plays, or only then."""


class UnknownEntityError(UsageError):
    """There is no robot or object of that name."""
