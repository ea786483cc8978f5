"""A node is one class: ports as typed fields on top, a short `compute` below.

    class DifferentialController(Node, type="isaacsim.robot.wheeled_robots.DifferentialController"):
        \"\"\"Wheel speeds of a two-wheeled base that follows a body twist.\"\"\"

        exec_in = ExecIn()
        linear_velocity: float = In(default=0.0, unit="m/s")
        velocity_command: Doubles = Out(unit="rad/s", doc="[left, right]")

        def compute(self) -> None: ...

The class is slotted: every port is one attribute of the instance, and the generated tick copies values between them. A test
sets inputs in the constructor and reads outputs after `compute`. The kind of a node follows from its ports
and methods:

| kind   | shape                                                                                              |
|--------|----------------------------------------------------------------------------------------------------|
| data   | no execution ports; `volatile=True` when its outputs depend on more than its inputs                 |
| action | `compute` returns None and its one ExecOut fires; if `gated`, or with several, it returns the ports to fire |
| event  | an action or pusher without ExecIn, computed at the start of each pass                              |
| pusher | `compute` is a generator of ports to fire; each yield runs all nodes downstream of that port        |
| latent | has `update`, called once a tick while `active`; it returns the ports to fire in the next pass      |

A graph is executed in passes, one each tick or one each physics step. An event node can also define `at_stop`, called
when a play ends, or `at_close`, called before its graph is closed. The ports that these methods return fire in a
separate pass between ticks, in which no other event node is computed. A node that publishes the time can define `announce_time`,
which is called with current inputs after a jump of the time, such as a reset.
"""

from __future__ import annotations

import builtins
import copy
import inspect
import re
import typing
import weakref
from collections.abc import Callable, Collection, Generator, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar, Literal, dataclass_transform

from graphengine.format.errors import GraphError
from graphengine.format.wording import did_you_mean, listing
from graphengine.node.port import MISSING, Bound, ExecIn, ExecOut, Field, In, Out, Port, State, exec_port, value_port
from graphengine.node.types import PortType

if TYPE_CHECKING:
    from graphengine.messages.definitions import Definitions
    from graphengine.node.context.context import Context

Kind = Literal["data", "action", "event", "pusher", "latent"]
Numbered = Mapping[str, Callable[[], Any]]
"""Functions that create numbered ports, by name prefix."""
Fire = int | None
"""Return type of a gated node's `compute`: the ExecOut ports to fire, joined by `|`, or None for no port."""

UNKNOWN_PRIM = "prim:*"
"""Resource key for a prim whose path is unknown because it comes from a wire."""

Ending = Literal["at_stop", "at_close"]
ENDINGS: tuple[Ending, ...] = typing.get_args(Ending)
"""Methods of event nodes that the engine calls between ticks."""

_RESERVED = re.compile(
    r"_|(type|tuple|input|id|hash|min|max|range|object|close|update|active|at_stop|at_close|announce_time)\Z"
)
"""Names reserved for class bodies and the engine."""


@dataclass_transform(kw_only_default=True, field_specifiers=(Bound, In, Out, State))
class NodeMeta(type):
    """Turns the fields of a class body into slots and a table of ports."""

    def __new__(
        mcs,
        name: str,
        bases: tuple[type, ...],
        namespace: dict[str, Any],
        *,
        type: str = "",
        gated: bool = False,
        counts: bool = False,
        volatile: bool = False,
        aliases: Sequence[str] = (),
    ) -> NodeMeta:
        """Create a node class; the docstring of `Node` lists the keywords."""
        fields = {k: v for k, v in namespace.items() if isinstance(v, Field | ExecIn | ExecOut)}
        inherited = [base for base in bases if isinstance(base, NodeMeta)]
        taken = {member for base in inherited for member in dir(base)}
        for field_name in fields:
            if field_name in taken or _RESERVED.match(field_name):
                raise TypeError(
                    f"{name}.{field_name}: the name is taken; call it {field_name}_in or {field_name}_out with name="
                )
        for field_name in fields:
            del namespace[field_name]
        slots = [*namespace.get("__slots__", ()), *(k for k, v in fields.items() if not isinstance(v, ExecOut))]
        namespace["__slots__"] = (*slots, "active") if "update" in namespace and "active" not in taken else tuple(slots)
        cls = super().__new__(mcs, name, bases, namespace)
        cls._make_ports(fields)  # type: ignore[attr-defined]
        cls.type_name = type  # type: ignore[attr-defined]
        several = len([p for p in cls.ports.values() if p.is_exec and p.side == "outputs"]) > 1  # type: ignore[attr-defined]
        for fact, here in (("gated", gated or several), ("counts", counts), ("volatile", volatile)):
            setattr(cls, fact, here or any(getattr(base, fact, False) for base in inherited))
        cls.aliases = tuple(aliases)  # type: ignore[attr-defined]
        cls.series = {stem: _series(cls.fields, stem) for stem in cls.numbered}  # type: ignore[attr-defined]
        return cls

    def __init__(cls, name: str, bases: tuple[type, ...], namespace: dict[str, Any], **_: Any) -> None:
        super().__init__(name, bases, namespace)


class Node(metaclass=NodeMeta):
    """Base of every node type.

    Class keywords: `type` is the registered OmniGraph name (a class without one is a base class); `gated` marks an
    action whose single ExecOut fires only when `compute` returns it; `counts` marks a node that is computed for every
    firing of its execution inputs, even several in one pass; `volatile` marks a data node whose outputs depend on more
    than its inputs; `aliases` are older registered names.

    Raises:
        TypeError: an argument of the constructor is not an input, or a value has the wrong type.
        ValueError: a value is out of range.
    """

    __slots__ = ("__weakref__", "settled")

    type_name: ClassVar[str]
    aliases: ClassVar[tuple[str, ...]]
    gated: ClassVar[bool]
    counts: ClassVar[bool]
    volatile: ClassVar[bool]
    numbered: ClassVar[Numbered] = {}
    """Functions that create the ports a graph file can add, by name prefix: `output` allows `output0`, `output1`, …"""
    series: ClassVar[Mapping[str, tuple[str, ...]]] = {}
    """Python names of the numbered ports, by name prefix, in numerical order."""
    max_pushes: ClassVar[int] = 100_000
    """Maximum number of yields of a pusher in one activation; the limit ends infinite loops."""
    rereads: ClassVar[bool] = False
    """Whether a pusher's inputs are updated after each yield; otherwise they keep the values from the start of `compute`."""
    fields: ClassVar[dict[str, Port]] = {}
    """Ports by Python name, base classes first."""
    ports: ClassVar[dict[str, Port]] = {}
    """Ports by `side:name`, as in `inputs:wheelRadius`."""
    _factories: ClassVar[dict[str, Callable[[], Any]]] = {}

    def __init__(self, **values: Any) -> None:
        cls = type(self)
        # What its graph settled ports of several types to, by Python name; a node of no graph goes by its values.
        self.settled: Mapping[str, PortType] = {}
        for port in cls.fields.values():
            if port.side == "inputs":
                setattr(self, port.field, 0 if port.is_exec else port.default)
        if hasattr(cls, "update"):
            self.active = False
        self.clear()
        for name, value in values.items():
            known = cls.fields.get(name)
            if known is None or known.side != "inputs" or known.is_exec:
                inputs = [p.field for p in cls.fields.values() if p.side == "inputs" and not p.is_exec]
                hint = did_you_mean(name, inputs) or listing(inputs, "inputs")
                raise TypeError(f"{cls.__name__} has no input {name!r}; {hint}")
            try:
                setattr(self, name, known.check(value))
            except (TypeError, ValueError) as error:
                raise type(error)(f"{cls.__name__}.{name}: {error}, got {value!r}") from None

    if TYPE_CHECKING:  # a slot of latent nodes, and to checkers no argument of the constructor

        @property
        def active(self) -> bool:
            """Whether the engine calls `update` of this latent node."""
            ...

        @active.setter
        def active(self, value: bool) -> None: ...

    @classmethod
    def kind(cls) -> Kind:
        """The kind of node, derived from its ports and methods."""
        exec_ports = [port for port in cls.fields.values() if port.is_exec]
        if not exec_ports:
            return "data"
        if hasattr(cls, "update"):
            return "latent"
        if inspect.isgeneratorfunction(cls.compute):
            return "pusher"
        return "action" if any(port.side == "inputs" for port in exec_ports) else "event"

    def setup(self, context: Context) -> None:
        """Get handles and endpoints from the context; inputs declared with `setup=True` already have their values."""

    def compute(self) -> Any:
        """Read inputs and write outputs. The module's docstring lists what each kind of node returns."""

    def reset(self) -> None:
        """Reset state that is not in Out or State fields (the engine resets those); called on stop."""

    def save(self) -> Any:
        """Return the node's state for a checkpoint: inputs, outputs and State fields, without Bound fields.

        A node class with other state overrides `save` and `restore`.
        """
        names = [port.field for port in type(self).fields.values() if not (port.bound_in_setup or port.mask)]
        if hasattr(type(self), "update"):
            names.append("active")
        return copy.deepcopy({name: getattr(self, name) for name in names})

    def restore(self, saved: Any) -> None:
        """Return to the state that `save` returned."""
        for name, value in copy.deepcopy(saved).items():
            setattr(self, name, value)

    def reads(self) -> Iterable[str]:
        """Return the keys of resources that the node reads besides its inputs and the clock, such as `variable:speed`."""
        return ()

    def writes(self) -> Iterable[str]:
        """Return the keys of resources that the node changes besides its outputs."""
        return ()

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """Return port types that follow from known ones, besides those of coupled ports; called until it returns no new type.

        Inputs already have the values of their literals. A returned type that the port does not allow, or that contradicts
        a known type, is reported as an error of the graph.

        Args:
            known: known port types, by Python name.
            variables: types of the graph's variables.

        Raises:
            ValueError: the known types are incompatible; the message says why.
        """
        return {}

    @classmethod
    def dynamic_ports(cls, literals: Mapping[str, Any], definitions: Definitions) -> Mapping[str, Any]:
        """Return additional ports by Python name, depending on the node's literals; called once, before wires are read.

        Entries of the mapping that are not ports must be hashable; they become attributes of the class with the ports.

        Args:
            literals: values of inputs in the graph file, by OmniGraph name.
            definitions: message types.
        """
        return {}

    @classmethod
    def grows(cls) -> bool:
        """Return whether a graph file can add ports: the class has `numbered` ports or overrides `dynamic_ports`."""
        return bool(cls.numbered) or cls.dynamic_ports.__func__ is not Node.dynamic_ports.__func__  # type: ignore[attr-defined]

    def clear(self) -> None:
        """Reset outputs and State fields to their defaults; an output of union type is set to the zero of its resolved type."""
        for port in type(self).fields.values():
            if port.side == "outputs" and not port.is_exec:
                settled = self.settled.get(port.field)
                setattr(self, port.field, settled.zero if settled else port.default)
            elif port.side == "state" and not port.bound_in_setup:
                factory = self._factories.get(port.field)
                setattr(self, port.field, factory() if factory else port.default)
        if hasattr(type(self), "update"):
            self.active = False

    @classmethod
    def _make_ports(cls, fields: dict[str, Any]) -> None:
        """Merge the fields of a class body with those of its bases into the port tables."""
        inherited: dict[str, Port] = {}
        factories: dict[str, Callable[[], Any]] = {}
        for base in reversed(cls.__mro__[1:]):
            inherited |= base.__dict__.get("fields", {})
            factories |= base.__dict__.get("_factories", {})
        hints = inspect.get_annotations(cls, eval_str=True) if fields else {}
        mask = 1 << sum(1 for port in inherited.values() if port.is_exec and port.side == "outputs")
        for name, field in fields.items():
            if isinstance(field, ExecIn | ExecOut):
                port = exec_port(name, field)
                if port.side == "outputs":
                    port = replace(port, mask=mask)
                    setattr(cls, name, mask)
                    mask <<= 1
            else:
                port = value_port(cls.__name__, name, field, hints.get(name))
                if field.factory:
                    factories[name] = field.factory
            inherited[name] = port
        cls.fields = inherited
        cls.ports = {f"{port.side}:{port.name}": port for port in inherited.values()}
        cls._factories = factories


_grown: weakref.WeakValueDictionary[tuple[Any, ...], type[Node]] = weakref.WeakValueDictionary()


def grown(
    cls: type[Node], literals: Mapping[str, Any], definitions: Definitions, wired: Iterable[str] = ()
) -> type[Node]:
    """Return the node type with its numbered and dynamic ports as slots; equal arguments give the same class.

    Args:
        cls: node type.
        literals: values of inputs in the graph file, by OmniGraph name.
        definitions: message types.
        wired: OmniGraph names of the wired ports.

    Raises:
        ContextError: the literals name an unknown message type.
        ValueError: the literals are invalid.
    """
    values = {name.removeprefix("inputs:"): value for name, value in literals.items()}
    ports = _numbered_ports(cls, [*values, *wired]) | dict(cls.dynamic_ports(values, definitions))
    if not ports:
        return cls
    key = (cls, *((name, _identity(member)) for name, member in ports.items()))
    made = _grown.get(key)
    if made is None:
        namespace = {"__module__": cls.__module__, "__doc__": cls.__doc__, "__qualname__": cls.__qualname__, **ports}
        meta = NodeMeta(cls.__name__, (cls,), namespace, type=cls.type_name)
        made = _grown[key] = typing.cast("type[Node]", meta)
    return made


def _number(name: str, stem: str) -> int | None:
    """The number after the stem of a port name, such as 0 in Isaac's branch00; None if there is no number."""
    match = re.fullmatch(rf"{stem}(0?[0-9]|[1-9][0-9]{{1,3}})", name)
    return int(match[1]) if match else None


def _numbered_ports(cls: type[Node], names: Collection[str]) -> dict[str, Any]:
    """Fields for the numbered ports to add to a class: those in `names` that the class lacks."""
    known = {port.name for port in cls.fields.values()}
    return {
        name: make()
        for stem, make in cls.numbered.items()
        for name in sorted(set(names) - known, key=lambda name: (len(name), name))
        if _number(name, stem) is not None
    }


def _series(fields: Mapping[str, Port], stem: str) -> tuple[str, ...]:
    numbers = {port.field: number for port in fields.values() if (number := _number(port.name, stem)) is not None}
    return tuple(sorted(numbers, key=lambda field: (numbers[field], field)))


def _identity(member: Any) -> Any:
    is_field = isinstance(member, Field | ExecIn | ExecOut)
    return f"{type(member).__name__} {vars(member)}" if is_field else member


def node(
    type: str, *, volatile: bool = False, aliases: Sequence[str] = ()
) -> Callable[[Callable[..., Any]], builtins.type[Node]]:
    """Make a data node from a function: arguments become inputs, the return value becomes the output `value`.

    Args:
        type: registered name.
        volatile: whether the result depends on more than the arguments.
        aliases: older registered names.
    """

    def make(function: Callable[..., Any]) -> NodeMeta:
        signature = inspect.signature(function)
        names = list(signature.parameters)
        annotations = dict(typing.get_type_hints(function, include_extras=True))
        namespace: dict[str, Any] = {"__module__": function.__module__, "__doc__": function.__doc__}
        for name, parameter in signature.parameters.items():
            default = MISSING if parameter.default is parameter.empty else parameter.default
            namespace[name] = Field("inputs", default)
        if "value" in namespace:
            raise TypeError(f"{function.__name__}.value: the output has this name; rename the argument")
        namespace["value"] = Field("outputs")
        annotations["value"] = annotations.pop("return", None)

        def compute(self: Any) -> None:
            self.value = function(*[getattr(self, name) for name in names])

        namespace |= {"__annotations__": annotations, "compute": compute}
        return NodeMeta(function.__name__, (Node,), namespace, type=type, volatile=volatile, aliases=aliases)

    return make  # type: ignore[return-value]


Pushes = Generator[int, None, None]
"""Return type of a pusher's `compute`."""


class NodeClassError(GraphError):
    """A node class that cannot be registered."""
