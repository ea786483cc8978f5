"""The exception classes of this package and their hierarchy.

GraphError                  base of all exceptions of this package
├── BadValueError           a node cannot use a value of an input; the run continues
├── CheckError              errors in the files of a graph or scene (in format/diagnostics.py)
├── ContextError            a node requested something missing or illegal from its context
│   ├── PrimError           no prim at a path, or a prim of the wrong kind
│   │   └── AmbiguousPrimError   a path that could mean several prims
│   ├── JointError          no such joint
│   ├── TopicError          a topic, namespace or QoS profile that is not legal in ROS 2
│   ├── MessageTypeError    an unknown or unusable message type (in messages/interfaces.py)
│   └── MissingMessageError a generic node without a message type (in nodes/ros2/fields.py)
├── ControlError            a running session could not be reached, or refused a command
├── ExpectationError        a run did not meet an expectation, or it could not be judged
├── NodeClassError          a node class that cannot be registered (in node/node_class.py)
├── NodeError               an exception in a node's `compute`
├── PhysicsError            the simulation diverged
├── ProgramError            a program of a scenario could not be started, or ended with an error (in experiments/programs.py)
├── RecordingError          a recording that cannot be written or read
├── RenderError             images cannot be rendered
├── TrajectoryError         a trajectory that is invalid for the joints (in nodes/ros2/joint_trajectory.py)
├── TransportError          joining the ROS 2 network, or communicating on it, failed
│   └── MessageError        a message that does not match its type (in messages/messages.py)
└── UsageError              invalid arguments (exit code 2 of `graphrun`)
    ├── BlockedPoseError    a robot or object would overlap others at its new pose
    ├── NoObstaclesError    a map of a world without obstacles needs bounds (in physics/occupancy/occupancy_map.py)
    ├── RefusedError        a refused request of simulation_interfaces (in control/simulation_interfaces/results.py)
    ├── StateError          a call that the state of the session does not allow
    └── UnknownEntityError  no robot or object has the name
"""

from __future__ import annotations

import reprlib


class GraphError(Exception):
    """Base of all exceptions of this package."""


class BadValueError(GraphError, ValueError):
    """A node cannot use the value of an input.

    If the value comes from a wire or was set during the run, and `bad_values` of the session is `drop`, the run continues without
    the nodes that this node would fire in the tick. Otherwise, the exception becomes a NodeError. A node raises the exception
    before it changes outputs, state or the world.

    Args:
        port: OmniGraph name of the input, such as `velocityCommand`; for inputs with incompatible values, their names: `a, b`.
        value: the value of the input.
        legal: description of the legal values, which follows "must be" in the message; empty: the message shows only the value.
    """

    def __init__(self, port: str, value: object, legal: str = "") -> None:
        text = " ".join(reprlib.repr(value).split())
        super().__init__(f"{port} must be {legal}, it is {text}" if legal else f"{port} cannot be {text}")
        self.port = port
        self.value = value

    def __str__(self) -> str:
        text = super().__str__()
        return f"{text}: {self.__cause__}" if self.__cause__ is not None else text


class ContextError(GraphError):
    """A node requested something from its context that does not exist or is not allowed.

    Args:
        message: text that says what is wrong.
        value: value of the input that caused the error; the finding has the position of this input in the file.
        help: lines of the finding's help, with legal values and remedies.
    """

    code = "G307"

    def __init__(self, message: str, value: object = None, *help: str) -> None:
        self.message = message
        self.value = value
        self.help = tuple(filter(None, help))
        super().__init__("\n".join((message, *self.help)))


class PrimError(ContextError):
    """A node requested a prim at a path where no prim exists, or where the prim is of the wrong kind."""

    code = "G301"


class AmbiguousPrimError(PrimError):
    """A node requested a prim by a path that matches several prims."""

    code = "G302"


class JointError(ContextError):
    """A node requested a joint that the robot does not have, by name or index."""

    code = "G303"


class TopicError(ContextError):
    """A topic name, namespace, QoS profile or domain is not legal in ROS 2."""

    code = "G304"


class ControlError(GraphError):
    """A running session could not be reached, or refused a command."""


class NodeError(GraphError):
    """A node raised an exception, which is the `__cause__` of the NodeError.

    Args:
        message: text with the exception, the node, its position in the file, its inputs and the tick.
        node: prim path of the node; empty if the node is unknown.
    """

    def __init__(self, message: str, node: str = "") -> None:
        super().__init__(message)
        self.node = node


class PhysicsError(GraphError):
    """The simulation diverged."""


class RecordingError(GraphError):
    """A recording cannot be written or read."""


class RenderError(GraphError):
    """Images cannot be rendered, because OpenGL is missing or failed."""


class TransportError(GraphError):
    """Joining the ROS 2 network, or communicating on it, failed."""


class UsageError(GraphError):
    """An argument of a command line or a call is invalid; `graphrun` then exits with code 2."""


class StateError(UsageError):
    """The session is in a state that does not allow the call, such as `pause` while it is stopped."""


class BlockedPoseError(UsageError):
    """A robot or object was not placed at a new pose, because it would overlap others."""


class ExpectationError(GraphError, AssertionError):
    """A run did not meet an expectation, or an expectation could not be judged; the message reports each."""


class UnknownEntityError(UsageError):
    """No robot or object has the name."""
