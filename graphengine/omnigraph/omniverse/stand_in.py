"""What takes the place of everything of Omniverse that builds no graphs: it can be called, read and set, and does nothing.

A stand-in is false and empty, so that loops over it and loops that wait for it end; taken apart it gives as many as are wanted.
It is no number: what would become one is told as unknown.
"""

from __future__ import annotations

import dis
import re
import sys
from collections.abc import Iterator, Mapping
from types import FrameType, ModuleType
from typing import Any

from graphengine.omnigraph.omniverse.plain_data import UnknownError, unknown
from graphengine.omnigraph.omniverse.recorder import Recorder

MAX_CALLS = 20_000
"""Calls of stand-ins after which a script is taken to go on without end, as one that steps a simulation does."""

MAX_SAID = 200
"""Characters of what a script logs that are told."""

_ASKS = re.compile(
    r"(get|is|has|can|enable|disable|find|new|log|update|next|close|play|step|render|reset|__)", re.IGNORECASE
)
"""How names of calls begin that change no stage, or nothing that a graph's file could hold."""

ELSEWHERE, OWN = "what a USD file holds", "a node of Omniverse's own"
"""Names of stand-ins for what is told already."""

_OF_GRAPHS = ("omni.graph.core.Controller.", "omni.graph.core.cmds.", "og.")
"""How names of stand-ins begin whose calls may well do something to graphs."""

_UNPACK = dis.opmap["UNPACK_SEQUENCE"]


class EndlessError(BaseException):
    """The script goes on without end; no exception that a script means to catch."""


class StandIn:
    """Something of Omniverse, by the name that a script reached it with."""

    is_unknown = True

    def __init__(self, name: str, recorder: Recorder) -> None:
        self.__dict__["_name"] = name
        self.__dict__["_recorder"] = recorder

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__") and name.endswith("__"):
            raise AttributeError(name)
        return StandIn(f"{self._name}.{name}", self._recorder)

    def __setattr__(self, name: str, value: Any) -> None:
        pass

    def __call__(self, *arguments: Any, **named: Any) -> Any:  # noqa: D102
        told(self._recorder, self._name)
        if self._name.startswith("carb.log_"):
            self._recorder.said.extend(text[:MAX_SAID] for text in arguments if isinstance(text, str))
        if len(arguments) == 1 and not named and callable(arguments[0]) and not isinstance(arguments[0], StandIn):
            return arguments[0]  # a decorator
        return StandIn(self._name if self._name.endswith(")") else f"{self._name}()", self._recorder)

    def __bool__(self) -> bool:
        return False

    def __len__(self) -> int:
        return 0

    def __iter__(self) -> Iterator[Any]:
        return iter([self] * _unpacked(sys._getframe(1)))

    def __getitem__(self, key: Any) -> Any:
        return StandIn(f"{self._name}[…]", self._recorder)

    def __setitem__(self, key: Any, value: Any) -> None:
        pass

    def __contains__(self, key: Any) -> bool:
        return False

    def __str__(self) -> str:
        return unknown(self._name)

    __repr__ = __fspath__ = __str__

    def __format__(self, form: str) -> str:
        return str(self)

    def __enter__(self) -> Any:
        return self

    def __exit__(self, *failure: Any) -> None:
        pass

    def __await__(self) -> Iterator[Any]:
        return iter(())

    def __instancecheck__(self, instance: Any) -> bool:
        return False

    def __mro_entries__(self, bases: tuple[Any, ...]) -> tuple[type, ...]:
        return (type("Base", (Base,), {"_recorder": self._recorder}),)

    def __add__(self, other: Any) -> Any:
        return f"{self}{other}" if isinstance(other, str) else self

    def __radd__(self, other: Any) -> Any:
        return f"{other}{self}" if isinstance(other, str) else self

    def _same(self, *_: Any) -> Any:
        return self

    __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = __rtruediv__ = __neg__ = _same
    __or__ = __ror__ = __and__ = __rand__ = __pow__ = __rpow__ = __matmul__ = __rmatmul__ = __mod__ = __rmod__ = _same
    __floordiv__ = __rfloordiv__ = __pos__ = __abs__ = __invert__ = __round__ = __xor__ = __rxor__ = _same

    def _never(self, _: Any) -> bool:
        return False

    __lt__ = __gt__ = __le__ = __ge__ = _never

    def plain_data(self) -> Any:
        """Nobody knows."""
        raise UnknownError(f"it comes from {self._name}")


def _unpacked(frame: FrameType) -> int:
    """How many values a frame is about to take apart, as in `a, b = …`; 0 where it does something else."""
    code, at = frame.f_code.co_code, frame.f_lasti
    return code[at + 1] if code[at] == _UNPACK else 0


class Awaitable:
    """What is over at once."""

    def __await__(self) -> Iterator[Any]:
        return iter(())


class Base:
    """Base of a class that a script derives from one of Omniverse."""

    _recorder: Recorder

    def __init__(self, *arguments: Any, **named: Any) -> None:
        pass

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return StandIn(f"{type(self).__name__}.{name}", self._recorder)


def idle(recorder: Recorder) -> None:
    """Count a call that builds nothing, and end a script that goes on without end."""
    recorder.idle_calls += 1
    if recorder.idle_calls > MAX_CALLS:
        raise EndlessError


def told(recorder: Recorder, name: str) -> None:
    """Note a call."""
    idle(recorder)
    last = name.replace("()", "").rpartition(".")[2]
    if _ASKS.match(last) or "[…]" in name or name.startswith((ELSEWHERE, OWN)):
        return
    call = f"{name.replace('()', '')}()"
    if name.startswith(_OF_GRAPHS):
        recorder.leave_out_once(f"what {call} does to graphs is left out")
    else:
        recorder.pass_over(call)


class StandInModule(ModuleType):
    """A module of stand-ins, but for what was put into it and for the modules below it that are known."""

    def __init__(
        self, name: str, recorder: Recorder, known: Mapping[str, ModuleType], members: Mapping[str, Any] | None = None
    ) -> None:
        super().__init__(name)
        self.__path__: list[str] = []
        self.__dict__.update(members or {})
        self.__dict__["_recorder"] = recorder
        self.__dict__["_known"] = known

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        full = f"{self.__name__}.{name}"
        return self._known.get(full) or StandIn(full, self._recorder)
