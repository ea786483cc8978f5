"""Evaluates the expressions that viewers plot: ports, variables, topics and bodies of a session, once per tick.

Syntax and functions are those of expectations: `port("robot/graph/Node.port")[0]`, `message("/odom").pose.pose.position.x`.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from types import CodeType
from typing import TYPE_CHECKING, Any

import numpy as np

from graphengine.format.errors import UsageError
from graphengine.messages import messages
from graphengine.messages.definitions import Definitions
from graphengine.messages.endpoints import EndpointClaim
from graphengine.runtime.addresses import find_port_at, find_variable_at
from graphengine.sandbox.expressions import FUNCTIONS, FieldGuard, ForbiddenError, compiled
from graphengine.view.live_topics import LARGEST, Listen, Newest
from graphengine.view.wire import PlotSamples

if TYPE_CHECKING:
    from graphengine.runtime.session_core import SessionCore

MAX_SERIES = 32
"""Maximum number of expressions that viewers plot at the same time; the others get an error."""
MAX_EXPRESSION = 500
"""Maximum length of an expression, characters."""
MAX_STEPS = 20_000
"""Maximum number of steps of one evaluation of an expression."""
MAX_SAMPLES = 20_000
"""Maximum number of unsent samples; if there are more, the oldest are discarded."""
MOST_CHOICES, MOST_ELEMENTS = 200, 8
"""Maximum number of parts to offer of a value that is not a number, and of elements of an array."""


class _NoValueError(Exception):
    """A reading has no value yet."""


class _PlotGuard(FieldGuard):
    """A guard with fewer steps, because an expression is evaluated in each tick."""

    def __init__(self) -> None:
        super().__init__()
        self._left = MAX_STEPS


@dataclass(frozen=True, slots=True)
class _Pose:
    position: tuple[float, ...]
    orientation: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class _Velocity:
    linear: tuple[float, ...]
    angular: tuple[float, ...]


class _Seen:
    """A tap of the network that keeps the newest message of each topic; for recordings, which nobody can subscribe to."""

    def __init__(self) -> None:
        self.found: dict[str, tuple[str, bytes]] = {}
        """Type and data of each topic's newest message."""
        self.active = False
        """Whether messages are kept: not while the page shows another time than that of the samples."""

    def write(self, claim: EndpointClaim, data: bytes) -> None:
        """Keep a message that a node published."""
        if self.active:
            self.found[claim.topic] = claim.message_type, data

    def deliver(self, claim: EndpointClaim, arrived: Sequence[bytes]) -> None:
        """Keep a message that a node's subscription received."""
        if arrived:
            self.write(claim, arrived[-1])


class PlotValues:
    """Values of expressions over time.

    Args:
        session: session that the expressions read.
        definitions: message types.
        listen: subscribes to a topic; None for a recording, in which nodes publish the messages that were recorded.

    Attributes:
        status: for each expression an error, or the parts that can be plotted instead of a value that is not a number.
        restarts: number of changes of the expressions; a recording is sampled again from its beginning after each.
    """

    def __init__(self, session: SessionCore, definitions: Definitions, listen: Listen | None) -> None:
        self._session = session
        self._definitions = definitions
        self._listen = listen
        self._codes: dict[str, CodeType | None] = {}
        """Compiled expressions; None for one that cannot be evaluated."""
        self._readings: dict[tuple[str, str], Callable[[], Any]] = {}
        """Functions that read ports and variables, by kind and address, or that raise why this is impossible."""
        self._seen: _Seen | None = None
        self._topics: dict[str, Newest] = {}
        """Subscriptions to the topics of expressions."""
        self._decoded: dict[str, tuple[bytes, Any]] = {}
        self._times: list[float] = []
        self._values: dict[str, list[float | None]] = {}
        self.status: dict[str, Mapping[str, Any]] = {}
        self.restarts = 0

    @property
    def wanted(self) -> bool:
        """Whether viewers plot expressions."""
        return bool(self._codes)

    def want(self, texts: Collection[str]) -> None:
        """Set the expressions to evaluate."""
        if set(texts) == set(self._codes):
            return
        for text in [text for text in self._codes if text not in texts]:
            del self._codes[text], self._values[text]
            self.status.pop(text, None)
        for text in texts:
            if text not in self._codes:
                self._codes[text] = self._compiled(text)
                self._values[text] = [None] * len(self._times)
        self.restarts += 1
        self.rebind()
        network = self._session.services.network
        if self._listen is None and self._codes and self._seen is None:
            self._seen = _Seen()
            network.tap(self._seen)
        elif not self._codes and self._seen is not None:
            network.untap(self._seen)
            self._seen = None

    def rebind(self) -> None:
        """Look up ports and topics again; call this after graphs or robots have changed."""
        self._readings.clear()
        for subscription in self._topics.values():
            subscription.close()
        self._topics.clear()
        self._decoded.clear()

    @contextlib.contextmanager
    def sampling(self) -> Iterator[None]:
        """Return a context for the samples of a recording: outside of it, messages of nodes are ignored."""
        if self._seen is not None:
            self._seen.active = True
        yield
        if self._seen is not None:
            self._seen.active = False

    def sample(self, time: float) -> None:
        """Evaluate all expressions after a tick; `time` is the time of the sample, s."""
        if len(self._times) >= MAX_SAMPLES:
            del self._times[: MAX_SAMPLES // 2]
            for column in self._values.values():
                del column[: MAX_SAMPLES // 2]
        self._times.append(time)
        for text, code in self._codes.items():
            self._values[text].append(self._number(text, code) if code is not None else None)

    def take(self) -> PlotSamples | None:
        """Return the samples since the last call; None without samples."""
        if not self._times:
            return None
        taken = PlotSamples(self._times, self._values)
        self._times, self._values = [], {text: [] for text in self._codes}
        return taken

    def _compiled(self, text: str) -> CodeType | None:
        self.status.pop(text, None)
        try:
            if len(text) > MAX_EXPRESSION:
                raise UsageError(f"an expression may have at most {MAX_EXPRESSION} characters")
            if len(self._codes) >= MAX_SERIES and text not in self._codes:
                raise UsageError(f"at most {MAX_SERIES} values can be plotted; remove others")
            return compiled(text, known=(*self._names(), *FUNCTIONS))
        except SyntaxError as error:
            self.status[text] = {"error": f"not an expression: {error.msg}"}
        except (ForbiddenError, ValueError, UsageError) as error:
            self.status[text] = {"error": str(error)}
        return None

    def _number(self, text: str, code: CodeType) -> float | None:
        """Return the value of an expression; None without a value, or if the value is not a finite number."""
        try:
            value = _PlotGuard().evaluate(code, {**FUNCTIONS, **self._names()})
        except _NoValueError:
            return None
        except Exception as error:  # functions and operators fail in many ways on unexpected values
            self.status[text] = {"error": str(error) or type(error).__name__}
            return None
        if isinstance(value, bool | int | float | np.number | np.bool_):
            self.status.pop(text, None)
            return float(value) if math.isfinite(value) else None
        if text not in self.status:
            choices = [suffix for suffix, _ in zip(_numbers(value), range(MOST_CHOICES), strict=False)]
            kind = "text" if isinstance(value, str) else type(value).__name__
            self.status[text] = {"choices": choices} if choices else {"error": f"{kind} is not a number"}
        return None

    def _names(self) -> dict[str, Callable[..., Any]]:
        """Return the functions that expressions may call in addition to `FUNCTIONS`."""
        return {
            "port": self._port,
            "variable": self._variable,
            "message": self._message,
            "pose": self._pose,
            "velocity": self._velocity,
            "time": lambda: self._session.time,
        }

    def _port(self, address: str) -> Any:
        return self._read("port", address, lambda: find_port_at(self._session.graphs, address))

    def _variable(self, address: str) -> Any:
        graph, _, name = address.rpartition("/")
        return self._read("variable", address, lambda: find_variable_at(self._session.graphs, graph, name))

    def _read(self, kind: str, address: str, find: Callable[[], Any]) -> Any:
        if not isinstance(address, str):
            raise UsageError(f"{kind}: the argument is a text, the address of a {kind}")
        if (kind, address) not in self._readings:
            try:
                found = find()
            except UsageError as error:
                raised = str(error)
                self._readings[kind, address] = lambda: _fail(raised)
            else:
                self._readings[kind, address] = lambda: found.value
        return self._readings[kind, address]()

    def _message(self, topic: str) -> Any:
        if not any(claim.topic == topic and not claim.is_service for claim in self._session.services.claims):
            raise UsageError(f"no graph of this session publishes or receives {topic}")
        kind, data = self._newest(topic)
        if data is None:
            raise _NoValueError
        if len(data) > LARGEST:
            raise UsageError(f"the messages of {topic} are larger than {LARGEST} bytes")
        if topic not in self._decoded or self._decoded[topic][0] is not data:
            self._decoded[topic] = data, messages.decode(data, kind, self._definitions)
        return self._decoded[topic][1]

    def _newest(self, topic: str) -> tuple[str, bytes | None]:
        """Return the type of a topic and its newest message."""
        if self._listen is None:
            return self._seen.found.get(topic, ("", None)) if self._seen is not None else ("", None)
        if topic not in self._topics:
            self._topics[topic] = self._listen(topic)
        return self._topics[topic].type, self._topics[topic].latest_data

    def _pose(self, body: str) -> _Pose:
        state = self._session.services.world.entities.state(body)
        return _Pose(state.position, state.orientation)

    def _velocity(self, body: str) -> _Velocity:
        state = self._session.services.world.entities.state(body)
        return _Velocity(state.linear_velocity, state.angular_velocity)


def _fail(text: str) -> None:
    raise UsageError(text)


def _numbers(value: Any, suffix: str = "", depth: int = 0) -> Iterator[str]:
    """Yield the suffixes of an expression, such as `.position.x` or `[0]`, that select the numbers in its value."""
    if isinstance(value, bool | int | float | np.number | np.bool_):
        yield suffix
    elif depth < 8 and is_dataclass(value):
        for field in fields(value):
            if not field.name.startswith("_"):
                yield from _numbers(getattr(value, field.name), f"{suffix}.{field.name}", depth + 1)
    elif depth < 8 and isinstance(value, list | tuple | np.ndarray):
        for index, part in enumerate(value[:MOST_ELEMENTS]):
            yield from _numbers(part, f"{suffix}[{index}]", depth + 1)
