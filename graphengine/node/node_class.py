"""A node is one class: ports as typed fields on top, a short `compute` below.

    class DifferentialController(Node, type="isaacsim.robot.wheeled_robots.DifferentialController"):
        \"\"\"Wheel speeds of a two-wheeled base that follows a body twist.\"\"\"

        exec_in = ExecIn()
        linear_velocity: float = In(default=0.0, unit="m/s")
        velocity_command: Doubles = Out(unit="rad/s", doc="[left, right]")

        def compute(self) -> None: ...

The class is slotted: every port is one attribute of the instance, the generated tick copies between them, and a test sets
them in the constructor and reads them after `compute`. What kind of node it is follows from its shape:

| kind   | shape                                                                                              |
|--------|----------------------------------------------------------------------------------------------------|
| data   | no execution ports; `volatile=True` when it reads what is outside its inputs                        |
| action | `compute` returns None and fires its one ExecOut; when `gated=True`, or with several, it returns what to fire |
| event  | an action or pusher without ExecIn, computed at the start of each pass                              |
| pusher | `compute` is a generator of ports to fire; each yield runs what hangs on that port to its end       |
| latent | has `update`, called once a tick while `active`; it returns what to fire in the next pass           |

Passes run in ticks. What is to happen between two of them starts at an event that has `at_stop`, called when a play ends, or
`at_close`, called before its graph is closed; what these return is fired in a pass of its own, in which nothing else starts.
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
from graphengine.node.port import (
    MISSING,
    Bound,
    ExecIn,
    ExecOut,
    Field,
    In,
    Out,
    Port,
    Side,
    State,
    camel_case,
    value_port,
)
from graphengine.node.types import EXECUTION, PortType

if TYPE_CHECKING:
    from graphengine.messages.definitions import Definitions
    from graphengine.node.context.context import Context

Kind = Literal["data", "action", "event", "pusher", "latent"]
Numbered = Mapping[str, Callable[[], Any]]
"""Makers of numbered ports, by the stem of their names."""
Fire = int | None
"""What `compute` of a gated node returns: ExecOut ports joined by `|`, or None for nothing."""

UNKNOWN_PRIM = "prim:*"
"""Key of what a node changes when only a wire says which prim it changes; it may be any."""

Ending = Literal["at_stop", "at_close"]
ENDINGS: tuple[Ending, ...] = typing.get_args(Ending)
"""Methods of events that are called outside of ticks."""

_RESERVED = re.compile(r"_|(type|tuple|input|id|hash|min|max|range|object|close|update|active|at_stop|at_close)\Z")
"""Names that a class body or the engine uses itself."""


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
        """See `Node` for the keywords."""
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

    Class keywords: `type` is the registered OmniGraph name (a class without one is a base for others); `gated` marks an action
    whose single ExecOut fires only when `compute` returns it; `counts` computes once for each activation instead of once a
    region run; `volatile` marks a data node that reads more than its inputs; `aliases` are older registered names.

    Raises:
        TypeError: the constructor was given a port that is not an input, or a value of the wrong type.
        ValueError: a value out of range.
    """

    __slots__ = ("__weakref__", "settled")

    type_name: ClassVar[str]
    aliases: ClassVar[tuple[str, ...]]
    gated: ClassVar[bool]
    counts: ClassVar[bool]
    volatile: ClassVar[bool]
    numbered: ClassVar[Numbered] = {}
    """Ports of which a file has as many as it names, by the stem of their names: with `output`, output0, output1 and so on."""
    series: ClassVar[Mapping[str, tuple[str, ...]]] = {}
    """Python names of the ports of each stem, in the order of their numbers."""
    max_pushes: ClassVar[int] = 100_000
    """Of a pusher: how often one activation may yield, lest a loop without end stops the simulation."""
    rereads: ClassVar[bool] = False
    """Of a pusher: after each yield its inputs are brought up to date; those of others keep what they had when it began."""
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
            """Of a latent node: whether `update` is to be called."""
            ...

        @active.setter
        def active(self, value: bool) -> None: ...

    @classmethod
    def kind(cls) -> Kind:
        """What the node's shape makes it."""
        exec_ports = [port for port in cls.fields.values() if port.is_exec]
        if not exec_ports:
            return "data"
        if hasattr(cls, "update"):
            return "latent"
        if inspect.isgeneratorfunction(cls.compute):
            return "pusher"
        return "action" if any(port.side == "inputs" for port in exec_ports) else "event"

    def setup(self, context: Context) -> None:
        """Ask the context for what the node needs; inputs marked `setup` have their values."""

    def compute(self) -> Any:
        """Read inputs, write outputs; see the module for what each kind returns."""

    def reset(self) -> None:
        """Forget what the defaults of Out and State do not cover; called on stop."""

    def save(self) -> Any:
        """What a checkpoint keeps of the node: its inputs, outputs and state, but for what `setup` binds.

        A node with state elsewhere has methods `save` and `restore` of its own.
        """
        names = [port.field for port in type(self).fields.values() if not port.bound_in_setup]
        names = [name for name in names if not type(self).fields[name].mask] + ["active"] * hasattr(
            type(self), "update"
        )
        return copy.deepcopy({name: getattr(self, name) for name in names})

    def restore(self, saved: Any) -> None:
        """Go back to what `save` returned."""
        for name, value in copy.deepcopy(saved).items():
            setattr(self, name, value)

    def reads(self) -> Iterable[str]:
        """Keys of what the node reads beside its inputs and the clock, such as `variable:speed`."""
        return ()

    def writes(self) -> Iterable[str]:
        """Keys of what the node changes beside its outputs."""
        return ()

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """Types of ports that follow from those of others, where `couple` does not say it; asked until nothing more follows.

        Literals are set. A type that a port does not take, or that contradicts what is known, is told as a mistake.

        Args:
            known: types of ports as far as they are settled, by Python name.
            variables: types of the graph's variables.

        Raises:
            ValueError: what is known does not go together; the message says why.
        """
        return {}

    @classmethod
    def dynamic_ports(cls, literals: Mapping[str, Any], definitions: Definitions) -> Mapping[str, Any]:
        """Fields that the node grows from its literals, by Python name; made once, before wires are read.

        Anything else in the mapping, which must be hashable, becomes an attribute of the class that has the fields.

        Args:
            literals: values in the file, by OmniGraph's name of the input.
            definitions: message types.
        """
        return {}

    @classmethod
    def grows(cls) -> bool:
        """Whether it has `dynamic_ports` of its own."""
        return bool(cls.numbered) or cls.dynamic_ports.__func__ is not Node.dynamic_ports.__func__  # type: ignore[attr-defined]

    def clear(self) -> None:
        """Set Out and State back to their defaults; an output of several types to the zero of the one it was settled to."""
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
        """Merge a class body's fields with those of its bases into the tables of ports."""
        inherited: dict[str, Port] = {}
        factories: dict[str, Callable[[], Any]] = {}
        for base in reversed(cls.__mro__[1:]):
            inherited |= base.__dict__.get("fields", {})
            factories |= base.__dict__.get("_factories", {})
        hints = inspect.get_annotations(cls, eval_str=True) if fields else {}
        mask = 1 << sum(1 for port in inherited.values() if port.is_exec and port.side == "outputs")
        for name, field in fields.items():
            if isinstance(field, ExecIn | ExecOut):
                side: Side = "inputs" if isinstance(field, ExecIn) else "outputs"
                ogn_name = field.name or camel_case(name)
                port = Port(name, ogn_name, side, EXECUTION, doc=field.doc, control=field.control)
                if side == "outputs":
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
    """The class with its dynamic ports as slots; the same arguments give the same class.

    Args:
        cls: node type.
        literals: values in the file, by OmniGraph's name of the input.
        definitions: message types.
        wired: OmniGraph's names of the ports that wires begin or end at.

    Raises:
        ContextError: the literals name a message that there is not.
        ValueError: they make no sense.
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
    """The number of a port's name after a stem, which may have two digits, as Isaac's editor writes branch00; None without."""
    match = re.fullmatch(rf"{stem}(0?[0-9]|[1-9][0-9]{{1,3}})", name)
    return int(match[1]) if match else None


def _numbered_ports(cls: type[Node], names: Collection[str]) -> dict[str, Any]:
    """Fields of the numbered ports among some names, which the class does not have already."""
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
    """Make a data node of a function: arguments become inputs, the return value the output `value`.

    Args:
        type: registered name.
        volatile: the function reads more than its arguments.
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
            raise TypeError(f"{function.__name__}.value: the name is taken by the output; call the argument otherwise")
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
