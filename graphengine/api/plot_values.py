"""Evaluates the expressions that viewers plot: ports, variables, topics and bodies of a session, once per tick.

Syntax and functions are those of expectations: `port("robot/graph/Node.port")[0]`, `message("/odom").pose.pose.position.x`.
"""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from types import CodeType
from typing import TYPE_CHECKING, Any

import numpy as np

from graphengine.devices.stage import Prim
from graphengine.format.errors import GraphError, UsageError
from graphengine.format.wording import unknown
from graphengine.messages import messages
from graphengine.messages.definitions import Definitions
from graphengine.messages.endpoints import EndpointClaim
from graphengine.runtime.addresses import find_port_at, find_variable_at
from graphengine.sandbox.expressions import FUNCTIONS, FieldGuard, ForbiddenError, compiled
from graphengine.view.live_topics import LARGEST, Listen, Newest
from graphengine.view.value_parts import BodyPose, BodyVelocity, numbers_in
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
MOST_CHOICES = 200
"""Maximum number of parts to offer of a value that is not a number."""


Evaluate = Callable[[], Any]
"""Function that returns the value of an expression."""
_PART = re.compile(r'(port|variable|message|pose|velocity)\("([^"\\]*)"\)((?:\.[a-z]\w*|\[\d+\])*)', re.ASCII)
_STEP = re.compile(r"\.(\w+)|\[(\d+)\]")


class _NoValueError(Exception):
    """A reading has no value yet."""


class _PlotGuard(FieldGuard):
    """A guard that allows `MAX_STEPS` of this module for each evaluation.

    A FieldGuard allows more steps, but here each expression is evaluated in every tick.
    """

    def renew(self) -> None:
        """Allow `MAX_STEPS` steps for the next evaluation."""
        self._left = MAX_STEPS


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
        self._guard = _PlotGuard()
        self._names: dict[str, Any] = {
            **FUNCTIONS,
            "port": self._port,
            "variable": self._variable,
            "message": self._message,
            "pose": self._pose,
            "velocity": self._velocity,
            "time": lambda: session.time,
        }
        self._codes: dict[str, Evaluate | None] = {}
        """Compiled expressions; None for one that cannot be evaluated."""
        self._readings: dict[tuple[str, str], Any] = {}
        """Handles to ports, variables and bodies, by kind and address; the error in place of a missing one."""
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

    def _compiled(self, text: str) -> Evaluate | None:
        self.status.pop(text, None)
        try:
            if len(text) > MAX_EXPRESSION:
                raise UsageError(f"an expression may have at most {MAX_EXPRESSION} characters")
            if len(self._codes) >= MAX_SERIES and text not in self._codes:
                raise UsageError(f"at most {MAX_SERIES} values can be plotted; remove others")
            return self._direct(text) or self._guarded(compiled(text, known=self._names))
        except SyntaxError as error:
            self.status[text] = {"error": f"not an expression: {error.msg}"}
        except (ForbiddenError, ValueError, UsageError) as error:
            self.status[text] = {"error": str(error)}
        return None

    def _guarded(self, code: CodeType) -> Evaluate:
        def evaluate() -> Any:
            self._guard.renew()
            return self._guard.evaluate(code, self._names)

        return evaluate

    def _direct(self, text: str) -> Evaluate | None:
        """Return a faster function for an expression that only reads a part of a value; None for other expressions."""
        found = _PART.fullmatch(text)
        if found is None:
            return None
        read, argument, steps = self._names[found[1]], found[2], _STEP.findall(found[3])

        def evaluate() -> Any:
            value = read(argument)
            for name, index in steps:
                value = self._guard.attribute(value, name) if name else value[int(index)]
            return value

        return evaluate

    def _number(self, text: str, code: Evaluate) -> float | None:
        """Return the value of an expression; None without a value, or if the value is not a finite number."""
        try:
            value = code()
        except _NoValueError:
            return None
        except Exception as error:  # functions and operators fail in many ways on unexpected values
            self.status[text] = {"error": str(error) or type(error).__name__}
            return None
        if isinstance(value, bool | int | float | np.number | np.bool_):
            self.status.pop(text, None)
            return float(value) if math.isfinite(value) else None
        if text not in self.status:
            choices = [suffix for suffix, _ in zip(numbers_in(value), range(MOST_CHOICES), strict=False)]
            kind = "text" if isinstance(value, str) else type(value).__name__
            self.status[text] = {"choices": choices} if choices else {"error": f"{kind} is not a number"}
        return None

    def _port(self, address: str) -> Any:
        return self._read("port", address, lambda: find_port_at(self._session.graphs, address)).value

    def _variable(self, address: str) -> Any:
        graph, _, name = address.rpartition("/")
        return self._read("variable", address, lambda: find_variable_at(self._session.graphs, graph, name)).value

    def _pose(self, body: str) -> BodyPose:
        return BodyPose(*self._read("pose", body, lambda: self._session.services.world.frame(self._prim(body))).pose())

    def _velocity(self, body: str) -> BodyVelocity:
        read = self._read("velocity", body, lambda: self._session.services.world.body(self._prim(body)))
        return BodyVelocity(*read.velocity())

    def _prim(self, body: str) -> Prim:
        """Return the prim of a robot or object, or with a prim path."""
        services = self._session.services
        names = {entity.name: entity.prim_path for entity in services.world.entities.all()}
        if body not in names and not body.startswith("/"):
            raise UsageError(unknown("entity", body, names))
        return services.stage.find(names.get(body, body))

    def _read(self, kind: str, address: str, find: Callable[[], Any]) -> Any:
        """Return the handle to a value, which is looked up once; raise UsageError if the lookup failed."""
        if not isinstance(address, str):
            raise UsageError(f"{kind}: the argument is a text, the address of what is read")
        key = kind, address
        if key not in self._readings:
            try:
                self._readings[key] = find()
            except GraphError as error:
                self._readings[key] = error
        if isinstance(self._readings[key], GraphError):
            raise UsageError(str(self._readings[key]))
        return self._readings[key]

    def _message(self, topic: str) -> Any:
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
        if topic in self._topics:
            return self._topics[topic].type, self._topics[topic].latest_data
        if self._seen is not None and topic in self._seen.found:
            return self._seen.found[topic]
        if not any(claim.topic == topic and not claim.is_service for claim in self._session.services.claims):
            raise UsageError(f"no graph of this session publishes or receives {topic}")
        if self._listen is not None:
            self._topics[topic] = self._listen(topic)
        return "", None
