"""The base class of nodes. A node type is one class with its ports as typed fields on top and a short `compute` below.

    class DifferentialController(Node, type="isaacsim.robot.wheeled_robots.DifferentialController"):
        \"\"\"Computes the wheel speeds of a differential-drive robot from the twist of its body.\"\"\"

        exec_in = ExecIn()
        linear_velocity: float = In(default=0.0, unit="m/s")
        velocity_command: Doubles = Out(unit="rad/s", doc="[left, right]")

        def compute(self) -> None: ...

Every port is one attribute (a slot) of the instance; the code that the compiler generates for a graph copies values between these
attributes. A test sets inputs in the constructor and reads outputs after `compute`. The kind of a node follows from its ports and
methods:

| kind   | ports and methods                                                                                      |
|--------|--------------------------------------------------------------------------------------------------------|
| data   | The node has no execution ports. It is `volatile` if its outputs depend on more than its inputs.       |
| action | After `compute`, its ExecOut fires. If `gated` or with several ExecOut, `compute` returns those to fire. |
| event  | The node is an action or pusher without ExecIn; it is computed at the start of each pass.              |
| pusher | `compute` is a generator of ports to fire; each yield executes all nodes downstream of the port.       |
| latent | `update` is called once per tick while `active` is true; it returns the ports to fire in the next pass. |

A data node is computed when an executed node reads its outputs, and only if a node upstream has been computed since then or the
data node is `volatile`. It may keep state in an output or a State field, but it misses values between two computations. A node
that has to see the values of every tick needs an ExecIn.

A graph is executed in passes, one for each tick or one for each physics step. An event node can also define `at_stop`, which is
called when the simulation stops, and `at_close`, which is called before the graph is closed. The ports that these methods return
fire in a separate pass between ticks, in which no other event node is computed. A node that publishes the time can define
`announce_time`, which is called with current inputs after the time has jumped, for example by a reset.
"""

from __future__ import annotations

import builtins
import copy
import inspect
import re
import typing
import weakref
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar, Literal, dataclass_transform

from graphengine.format.errors import GraphError
from graphengine.format.wording import did_you_mean, got_value, listing
from graphengine.node.port import MISSING, Bound, ExecIn, ExecOut, Field, In, Out, Port, State, exec_port, value_port
from graphengine.node.types import PortType

if TYPE_CHECKING:
    from graphengine.messages.definitions import Definitions
    from graphengine.node.context.context import Context

Kind = Literal["data", "action", "event", "pusher", "latent"]
Numbered = Mapping[str, Callable[[], Any]]
"""Type of `Node.numbered`: for each name prefix, a function that creates one port with this prefix and a number."""

UNKNOWN_PRIM = "prim:*"
"""Resource key of a prim whose path is not known before the run because it comes from a wire."""

Ending = Literal["at_stop", "at_close"]
REFUSALS = (ValueError, GraphError)
"""Exceptions with which a node may refuse values."""
ENDINGS: tuple[Ending, ...] = typing.get_args(Ending)
"""Names of the methods of event nodes that the engine calls between ticks."""

_RESERVED = re.compile(
    r"_|(type|tuple|input|id|hash|min|max|range|object|close|update|active|at_stop|at_close|announce_time)\Z"
)
"""Names that a port field cannot have, because the engine or code in class bodies uses them."""


@dataclass_transform(kw_only_default=True, field_specifiers=(Bound, In, Out, State))
class NodeMeta(type):
    """The metaclass of nodes. It turns the port fields of a class body into slots and a table of ports."""

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
        """Create a node class. The docstring of `Node` describes the keywords."""
        fields = {k: v for k, v in namespace.items() if isinstance(v, Field | ExecIn | ExecOut)}
        inherited = [base for base in bases if isinstance(base, NodeMeta)]
        taken = {member for base in inherited for member in dir(base)}
        for field_name in fields:
            if field_name in taken or _RESERVED.match(field_name):
                remedy = f"call it {field_name}_in or {field_name}_out, and set the port's name with name="
                raise TypeError(f"{name}.{field_name}: the name is taken; {remedy}")
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


class Node(metaclass=NodeMeta):
    """Base class of all node types.

    A node class takes these class keywords:

    - `type`: registered OmniGraph name of the node type; a class without it is only a base class.
    - `gated`: an action with a single ExecOut fires this ExecOut only if `compute` returns it.
    - `counts`: the node is computed once for each firing of an execution input, even if an input fires several times in a pass.
    - `volatile`: the outputs of a data node depend on more than its inputs.
    - `aliases`: older registered names.

    The constructor takes the values of inputs as keyword arguments.

    Raises:
        TypeError: an argument is not an input of the node, or a value has the wrong type.
        ValueError: a value is out of range.
    """

    __slots__ = ("__weakref__", "settled")

    type_name: ClassVar[str]
    aliases: ClassVar[tuple[str, ...]]
    gated: ClassVar[bool]
    counts: ClassVar[bool]
    volatile: ClassVar[bool]
    numbered: ClassVar[Numbered] = {}
    """Functions that create the ports a graph file can add, by name prefix. The prefix `output` allows `output0`, `output1`, …"""
    series: ClassVar[Mapping[str, tuple[str, ...]]] = {}
    """Python names of the numbered ports, by name prefix, in numerical order."""
    max_pushes: ClassVar[int] = 100_000
    """Maximum number of yields in one call of a pusher's `compute`; the limit ends infinite loops."""
    rereads: ClassVar[bool] = False
    """Whether a pusher's inputs are updated after each yield; if not, they keep the values from the start of `compute`."""
    fields: ClassVar[dict[str, Port]] = {}
    """All ports by Python name; the ports of base classes come first."""
    ports: ClassVar[dict[str, Port]] = {}
    """All ports by side and OmniGraph name, such as `inputs:wheelRadius`."""
    _factories: ClassVar[dict[str, Callable[[], Any]]] = {}

    def __init__(self, **values: Any) -> None:
        cls = type(self)
        # The types to which the compiler resolved union and `any` ports, by Python name; empty for a node outside a graph.
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
                raise type(error)(f"{cls.__name__}.{name}: {error}{got_value(error, value)}") from None

    if TYPE_CHECKING:  # latent nodes have a slot `active`; as a property, it is not an argument of the constructor

        @property
        def active(self) -> bool:
            """Whether the engine calls `update` in each tick; only latent nodes have this attribute, and set it themselves."""
            ...

        @active.setter
        def active(self, value: bool) -> None: ...

    @classmethod
    def kind(cls) -> Kind:
        """Return the kind of this node type, which follows from its ports and methods; see `graphengine.node.node_class`."""
        exec_ports = [port for port in cls.fields.values() if port.is_exec]
        if not exec_ports:
            return "data"
        if hasattr(cls, "update"):
            return "latent"
        if inspect.isgeneratorfunction(cls.compute):
            return "pusher"
        return "action" if any(port.side == "inputs" for port in exec_ports) else "event"

    def setup(self, context: Context) -> None:
        """Get handles and endpoints from the context. Inputs that are declared with `setup=True` already have their values."""

    def compute(self) -> Any:
        """Read the inputs and write the outputs. What it returns depends on the kind; see `graphengine.node.node_class`."""

    def reset(self) -> None:
        """Reset state that is not in Out or State fields; the engine resets these fields and calls `reset` at each stop."""

    def save(self) -> Any:
        """Return the node's state for a checkpoint: inputs, outputs and State fields, without Bound fields.

        A node class that keeps state elsewhere overrides `save` and `restore`.
        """
        names = [port.field for port in type(self).fields.values() if not (port.bound_in_setup or port.mask)]
        if hasattr(type(self), "update"):
            names.append("active")
        return copy.deepcopy({name: getattr(self, name) for name in names})

    def restore(self, saved: Any) -> None:
        """Restore a state that `save` returned."""
        for name, value in copy.deepcopy(saved).items():
            setattr(self, name, value)

    def reads(self) -> Iterable[str]:
        """Return the keys of the resources that the node reads, such as `variable:speed`; inputs and the clock are left out."""
        return ()

    def writes(self) -> Iterable[str]:
        """Return the keys of the resources that the node changes, such as `variable:speed`; outputs are left out."""
        return ()

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """Derive types of union and `any` ports from the types of other ports, and return them by Python name of the port.

        The compiler calls this method until it returns no new type. The compiler itself resolves ports that are declared with the
        keyword `couple`. Before the first call, each input for which the graph file gives a value has this value. If a port
        does not allow a returned type, or has a different type already, the compiler reports an error.

        Args:
            known: a dict from Python names of ports to their types, as far as these are known.
            variables: types of the graph's variables, by name.

        Raises:
            ValueError: the known types are incompatible; the message says why.
        """
        return {}

    @classmethod
    def dynamic_ports(cls, literals: Mapping[str, Any], definitions: Definitions) -> Mapping[str, Any]:
        """Return the ports that a node has in addition to those of its class, such as one for each field of its message type.

        The keys are the Python names of the ports. Values that are not ports become attributes of the node's class; they must be
        hashable. The compiler calls this method once per node, before it reads the wires.

        Args:
            literals: values of the node's inputs in the graph file, by OmniGraph name.
            definitions: definitions of message types.
        """
        return {}

    @classmethod
    def grows(cls) -> bool:
        """Return whether nodes of the class can have additional ports: it sets `numbered` or overrides `dynamic_ports`."""
        return bool(cls.numbered) or cls.dynamic_ports.__func__ is not Node.dynamic_ports.__func__  # type: ignore[attr-defined]

    def clear(self) -> None:
        """Reset outputs and State fields to their defaults. An output of union type is set to the zero of its resolved type."""
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
    """Return the class for one node of a graph: the node type, or a subclass of it with the node's additional ports.

    Nodes with the same type and the same additional ports share a class.

    Args:
        cls: node type.
        literals: values of the node's inputs in the graph file, by OmniGraph name.
        definitions: definitions of message types.
        wired: OmniGraph names of the node's wired ports; with the literals, they select the numbered ports.

    Raises:
        ContextError: a literal names an unknown message type.
        ValueError: a literal is invalid.
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
    """Return the number that follows the stem in a port name, such as 0 for Isaac's `branch00`; None if there is no number."""
    match = re.fullmatch(rf"{stem}(0?[0-9]|[1-9][0-9]{{1,3}})", name)
    return int(match[1]) if match else None


def _numbered_ports(cls: type[Node], names: Collection[str]) -> dict[str, Any]:
    """Return a new field for each of `names` that is the name of a numbered port and not yet a port of the class."""
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
    """Return a decorator that makes a data node from a function.

    The arguments of the function become inputs, and its return value becomes the output `value`.

    Args:
        type: registered OmniGraph name of the node type.
        volatile: whether the return value depends on more than the arguments.
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
            raise TypeError(f"{function.__name__}.value: the name is reserved for the output; rename the argument")
        namespace["value"] = Field("outputs")
        annotations["value"] = annotations.pop("return", None)

        def compute(self: Any) -> None:
            self.value = function(*[getattr(self, name) for name in names])

        namespace |= {"__annotations__": annotations, "compute": compute}
        return NodeMeta(function.__name__, (Node,), namespace, type=type, volatile=volatile, aliases=aliases)

    return make  # type: ignore[return-value]


class NodeClassError(GraphError):
    """A node class cannot be registered."""
