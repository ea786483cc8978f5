"""Stubs for all objects of Omniverse that do not build graphs; calls, attributes and items of a stub are stubs too.

A stub is false and empty, so that loops over a stub and loops that wait for it end. Unpacking a stub gives as many stubs as
needed. Numbers that are computed from a stub, such as `max(0.0, stub)`, are stubs, so that no value is invented.
"""

from __future__ import annotations

import dis
import functools
import re
import sys
from collections.abc import Iterator, Mapping
from types import FrameType, FunctionType, MethodType, ModuleType
from typing import Any

from graphengine.isaac.omniverse.plain_data import MAX_DEPTH, UnknownError, unknown
from graphengine.isaac.omniverse.ros_writers import is_ros_writer
from graphengine.isaac.omniverse.script_notes import ScriptNotes

MAX_SAID = 200
"""Maximum number of characters of a script's log message that a finding quotes."""

_ASKS = re.compile(
    r"(get|is|has|can|enable|disable|find|new|log|update|next|close|play|step|render|reset|__)", re.IGNORECASE
)
"""Matches the names of functions that change nothing in a graph; calls of these functions are not reported."""

ELSEWHERE, OWN = "an object of a USD file", "an attribute of an unknown node"
"""Names of stubs for objects that another finding already reports as left out; calls of these stubs are not reported."""
_WRITER = "a ROS 2 writer"
"""Name of the stubs of ROS 2 writers, which report the topics that are left out."""

_DRAWS = frozenset(("update", "step", "render", "next_update_async"))
"""Names of functions that render a frame."""

_RUNS = {"is_running": True, "is_playing": True, "is_exiting": False}
"""Names of functions that query whether the application runs, with the return value while it runs."""

_OF_GRAPHS = re.compile(r"(^|\.)(omni\.graph\.core\.cmds|og|Controller)\.|(^|\.)(edit|\w*[gG]raphs?)$")
"""Matches the names of functions that may edit graphs; calls of these functions are reported as warnings."""

_QUESTION = re.compile(r"(is|has|enable|set|add|load|open|create)(_|[A-Z])|exists")
"""Matches the names of functions whose result is true if the objects that a script uses are assumed to exist."""

_REGISTERS = re.compile(r"callback|subscri|observe|listener|handler|timer", re.IGNORECASE)
"""Matches the names of functions that register callbacks, such as `add_physics_callback` or `create_subscription_to_pop`."""
_FUNCTIONS = (FunctionType, MethodType, functools.partial)

_CALLS = re.compile(r"\(\)|\(#\d+\)|#\d+")
"""Matches the marks for calls and arguments, such as `()`, `(#2)` or `#2`, in the name of a stub."""

_NUMBERS = frozenset(("complex", "divmod", "float", "int", "map", "max", "min", "pow", "range", "round"))
"""Names of the built-in functions that compute numbers."""
_NUMERIC = frozenset(("math", "numpy", "random", "statistics"))
"""Names of the modules whose functions compute numbers."""

_UNPACK = dis.opmap["UNPACK_SEQUENCE"]


class StubObject:
    """Stub of an object of Omniverse; its name is the expression with which the script obtained the object."""

    is_unknown = True

    def __new__(cls, name: str, recorder: ScriptNotes) -> Any:
        """Create an instance of a subclass whose name contains `name`, so that Python's error messages show it."""
        made = super().__new__(_named(cls, _CALLS.sub("", name)))  # type: ignore[arg-type]
        made.__dict__.update(_name=name, _recorder=recorder)
        return made

    def __init__(self, *arguments: Any, **named: Any) -> None:
        """Do nothing; scripts may call the `__init__` of a base class that is a stub."""

    def __getattr__(self, name: str) -> Any:
        return member(self._name, name, self._recorder)

    def __setattr__(self, name: str, value: Any) -> None:
        pass

    def __call__(self, *arguments: Any, **named: Any) -> Any:  # noqa: D102
        if writer := next(filter(is_ros_writer, arguments), ""):
            return RosWriter(_WRITER, self._recorder).publish(writer, named)
        told(self._recorder, self._name)
        last = self._name.rpartition(".")[2]
        if last in _RUNS and (last != "is_playing" or self._recorder.frames.loops):
            runs = self._recorder.frames.go_on()
            self._recorder.idle_calls *= not runs  # the limit counts the calls of one frame
            return runs == _RUNS[last]
        if self._name.startswith("carb.log_"):
            self._recorder.said.extend(text[:MAX_SAID] for text in arguments if isinstance(text, str))
        if _REGISTERS.search(last):
            every = (*arguments, *named.values())
            self._recorder.callbacks.extend(one for one in every if isinstance(one, _FUNCTIONS))
        elif len(arguments) == 1 and not named and callable(arguments[0]) and not isinstance(arguments[0], StubObject):
            return arguments[0]  # a decorator
        given = tuple(map(_comparable, (*arguments, *named, *named.values())))
        name = self._name if self._name.endswith(")") else f"{self._name}()"
        made = StubObject(self._recorder.tell_apart(name, given), self._recorder)
        if last[:1].isupper():  # the call creates an instance, which keeps its arguments
            vars(made).update({**named, **vars(made)})
        return made

    def __bool__(self) -> bool:
        name = _CALLS.sub("", self._name)
        asks = self._name.endswith(")") and _QUESTION.match(name.rpartition(".")[2])
        yes = asks and self._recorder.assumed and not self._recorder.frames.tire()
        return bool(yes) or self._recorder.holds(name)

    def __len__(self) -> int:
        return 0

    def __iter__(self) -> Iterator[Any]:
        wanted = _unpacked(sys._getframe(1))
        if not wanted:
            self._recorder.search(_CALLS.sub("", self._name))
        return iter([self] * wanted)

    def __getitem__(self, key: Any) -> Any:
        return StubObject(self._recorder.tell_apart(f"{self._name}[…]", _comparable(key)), self._recorder)

    def __setitem__(self, key: Any, value: Any) -> None:
        pass

    def __str__(self) -> str:
        return unknown(self._name)

    __repr__ = __fspath__ = __str__

    def __format__(self, form: str) -> str:
        return str(self)

    def __exit__(self, *failure: Any) -> None:
        pass

    def __await__(self) -> Iterator[Any]:
        return iter(())

    def __bytes__(self) -> bytes:
        raise TypeError(f"a bytes-like object is required, not {type(self).__name__!r}")

    def __mro_entries__(self, bases: tuple[Any, ...]) -> tuple[type, ...]:
        return (type("Base", (StubBase,), {"_recorder": self._recorder, "_stands_for": self._name}),)

    def __add__(self, other: Any) -> Any:
        return f"{self}{other}" if isinstance(other, str) else self

    def __radd__(self, other: Any) -> Any:
        return f"{other}{self}" if isinstance(other, str) else self

    def _same(self, *_: Any) -> Any:
        return self

    __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = __rtruediv__ = __neg__ = _same
    __or__ = __ror__ = __and__ = __rand__ = __pow__ = __rpow__ = __matmul__ = __rmatmul__ = __mod__ = __rmod__ = _same
    __floordiv__ = __rfloordiv__ = __pos__ = __abs__ = __invert__ = __round__ = __xor__ = __rxor__ = __enter__ = _same

    __array_ufunc__ = __copy__ = __deepcopy__ = _same
    __hash__ = object.__hash__

    def __eq__(self, other: object) -> bool:
        return self is other or self._recorder.holds(f"{_CALLS.sub('', self._name)} == {other}")

    def _compare(self, sign: str, other: Any) -> Any:
        return StubObject(f"{self._name} {sign} {other}", self._recorder)

    __lt__ = __le__ = functools.partialmethod(_compare, "<")
    __gt__ = __ge__ = functools.partialmethod(_compare, ">")

    def _never(self, _: Any) -> bool:
        return False

    __contains__ = __instancecheck__ = _never

    def plain_data(self) -> Any:
        """Raise UnknownError, because only Omniverse knows the value."""
        raise UnknownError(f"it comes from {self._name}, which only Omniverse knows")


class RosWriter(StubObject):
    """Stub of a writer of Replicator that publishes a ROS 2 topic."""

    def publish(self, writer: str, named: Mapping[str, Any]) -> RosWriter:
        """Set the name of the writer, and report the topic if it is among the arguments; return this stub."""
        vars(self)["_writer"] = writer
        if "topicName" in named:
            self._recorder.lose_topic(writer, named)
        return self

    def initialize(self, **named: Any) -> None:
        """Report the topic, which is left out."""
        self._recorder.lose_topic(self._writer, named)


def of_unknown(function: Any) -> Any:
    """Return a wrapper of a numeric function that returns a stub if an argument is or contains one.

    All other functions are returned unchanged.
    """
    if not callable(function) or type(function).__module__ not in ("builtins", "numpy"):
        return function
    module = str(getattr(function, "__module__", None) or type(function).__module__).partition(".")[0]
    if module not in _NUMERIC and (module != "builtins" or function.__name__ not in _NUMBERS):
        return function

    def called(*given: Any, **named: Any) -> Any:
        found = next(_stubs((*given, *named.values()), 1 if function is map else MAX_DEPTH), None)
        if found is not None:
            return found
        return map(of_unknown(given[0]), *given[1:]) if function is map else function(*given, **named)

    return called


def _stubs(values: Any, depth: int) -> Iterator[StubObject]:
    """Yield the stubs in nested lists and tuples, at most `depth` levels deep."""
    for value in values if depth else ():
        if isinstance(value, StubObject):
            yield value
        elif isinstance(value, list | tuple):
            yield from _stubs(value, depth - 1)


@functools.lru_cache(4096)
def _named(cls: type[StubObject], name: str) -> type[StubObject]:
    return type(f"unknown value of {name}", (cls,), {"__module__": cls.__module__})


def _unpacked(frame: FrameType) -> int:
    """Return the number of targets if the frame executes an unpacking such as `a, b = …`; otherwise 0."""
    code, at = frame.f_code.co_code, frame.f_lasti
    return code[at + 1] if code[at] == _UNPACK else 0


def _comparable(value: Any) -> Any:
    """Return a key for an argument of a stub: a string or number itself, the name of a stub, None for all other types."""
    return value if isinstance(value, str | int | float) else str(value) if isinstance(value, StubObject) else None


def member(owner: str, name: str, recorder: ScriptNotes) -> Any:
    """Return a stub for the member `name` of a stub; special names such as `__len__` raise AttributeError.

    A member `og` is assumed to be the module `omni.graph.core`, and this assumption is reported.
    """
    if name.startswith("__"):
        raise AttributeError(name)
    if name == "og":
        recorder.findings.add("N302", f"{owner}.og is assumed to be omni.graph.core", recorder.where(""))
        return recorder.modules["omni.graph.core"]
    return StubObject(f"{owner}.{name}", recorder)


class StubBase:
    """Base class that replaces an Omniverse class from which a class of the script is derived."""

    _recorder: ScriptNotes

    def __init_subclass__(cls) -> None:
        """Add a stub for each method that the class calls through `super()`, which does not use `__getattr__`."""
        base = next(one for one in cls.__mro__ if "_recorder" in vars(one))
        codes = (getattr(member, "__code__", None) for member in vars(cls).values())
        names = {name for code in codes if code and "super" in code.co_names for name in code.co_names}
        for name in names:
            if not name.startswith("__") and not hasattr(base, name):
                setattr(base, name, StubObject(f"{cls.__name__}.{name}", cls._recorder))

    def __init__(self, *arguments: Any, **named: Any) -> None:
        vars(self).update(named)

    def __getattr__(self, name: str) -> Any:
        return member(type(self).__name__, name, self._recorder)


def told(recorder: ScriptNotes, name: str) -> None:
    """Record a call of the stub `name`: count a rendered frame, or report the change that the call would make."""
    recorder.idle()
    name = _CALLS.sub("", name)
    last = name.rpartition(".")[2]
    if last in _DRAWS:
        recorder.frames.draw()
    if _ASKS.match(last) or name.startswith((ELSEWHERE, OWN, _WRITER)):
        return
    if _OF_GRAPHS.search(name):
        recorder.leave_out(f"the effect of {name}() on graphs is left out")
    elif "[…]" not in name:
        recorder.pass_over(f"{name}()")


class Builtins(dict[str, Any]):
    """The built-in names of a script. After `from MODULE import *` with a stub module, undefined names become stubs."""

    recorder: ScriptNotes

    def __missing__(self, name: str) -> Any:
        if not self.recorder.starred:
            raise KeyError(name)
        return member(self.recorder.starred[-1], name, self.recorder)


class StubModule(ModuleType):
    """A module whose members are stubs, except for `members` and for submodules in `known`."""

    def __init__(
        self, name: str, recorder: ScriptNotes, known: Mapping[str, ModuleType], members: Mapping[str, Any] = {}
    ) -> None:
        super().__init__(name)
        vars(self).update(members, _recorder=recorder, _known=known)

    def __getattr__(self, name: str) -> Any:
        if name == "__all__":  # `from … import *`
            self._recorder.starred.append(self.__name__)
        return self._known.get(f"{self.__name__}.{name}") or member(self.__name__, name, self._recorder)
