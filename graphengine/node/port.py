"""Ports of a node class: the field specifiers for the class body, and the description of a port."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal, TypeVar, overload

from graphengine.node.types import ANY, EXECUTION, PortType, UnionType, coerce, first_that_takes, parse

T = TypeVar("T")
Side = Literal["inputs", "outputs", "state"]

MISSING: Any = object()
"""Marks a missing default."""

_TOLD = 20
"""Maximum number of legal strings in a message."""


@dataclass(frozen=True, slots=True)
class Port:
    """One port of a node type, with its OmniGraph name and its Python field."""

    field: str
    name: str
    side: Side
    type: PortType | UnionType
    default: Any = None
    doc: str = ""
    unit: str = ""
    ge: float | None = None
    gt: float | None = None
    le: float | None = None
    lt: float | None = None
    tokens: tuple[str, ...] = ()
    required: bool | str = False
    """True: the port needs a literal or a wire. A string: one of the ports with this string needs a literal or a wire."""
    default_counts: bool = False
    """Whether a literal that equals the default is one that a required port needs."""
    setup: bool = False
    control: bool = False
    extension: bool = False
    couple: str = ""
    component: bool = False
    element: bool = False
    bound_in_setup: bool = False
    mask: int = 0

    @property
    def is_exec(self) -> bool:
        """Whether the port carries execution rather than a value."""
        return isinstance(self.type, PortType) and self.type.base == EXECUTION.base

    @property
    def constraint(self) -> str:
        """The legal values in words; empty if every value of the type is legal."""
        if self.tokens:
            return "one of " + ", ".join(self.tokens)
        signs = (("≥", self.ge), (">", self.gt), ("≤", self.le), ("<", self.lt))
        return " and ".join(f"{sign} {bound:g}" for sign, bound in signs if bound is not None)

    def check(self, value: Any) -> Any:
        """Convert a literal to the port's representation.

        Raises:
            TypeError: the literal has another type.
            ValueError: the literal is out of range.
        """
        if isinstance(self.type, UnionType):
            return value
        value = coerce(value, self.type)
        if self.tokens and value not in self.tokens:
            more = f", … ({len(self.tokens) - _TOLD} more)" if len(self.tokens) > _TOLD else ""
            raise ValueError(f"expected one of {', '.join(self.tokens[:_TOLD])}{more}")
        if isinstance(value, int | float) and not isinstance(value, bool):
            low_enough = (self.le is None or value <= self.le) and (self.lt is None or value < self.lt)
            high_enough = (self.ge is None or value >= self.ge) and (self.gt is None or value > self.gt)
            if math.isnan(value) or not (low_enough and high_enough):
                raise ValueError(f"expected a value {self.constraint}" if self.constraint else "expected a number")
        return value


@dataclass(eq=False)
class Field:
    """A field specifier in a class body, replaced by a port when the class is created."""

    side: Side
    default: Any = MISSING
    factory: Callable[[], Any] | None = None
    facts: Mapping[str, Any] = field(default_factory=dict)


class ExecIn:
    """An execution input. On a node, its value is the number of times that the input fired in this activation."""

    def __init__(self, *, name: str = "", doc: str = "", control: bool = False) -> None:
        self.name, self.doc, self.control = name, doc, control

    if TYPE_CHECKING:

        def __get__(self, instance: object, owner: type) -> int: ...

        def __set__(self, instance: object, value: int) -> None: ...


class ExecOut:
    """An execution output. `compute` returns or yields it to fire it."""

    def __init__(self, *, name: str = "", doc: str = "") -> None:
        self.name, self.doc, self.control = name, doc, False

    if TYPE_CHECKING:

        def __get__(self, instance: object, owner: type) -> int: ...


@overload
def In(*, default: T, **facts: Any) -> T: ...
@overload
def In(**facts: Any) -> Any: ...
def In(*, default: Any = MISSING, **facts: Any) -> Any:
    """An input, set by a literal or a wire.

    Args:
        default: value without a literal or a wire. If left out, it is the zero of the port's type, and type checkers
            require the input in the constructor.
        facts: `doc`, `unit`, `ge`, `gt`, `le`, `lt`, `tokens` (the legal strings), `name` (OmniGraph's name, if it is
            not the field's name in camel case), `type` (OmniGraph's type, if the annotation does not give it, as for a
            union), `required` (True: the port needs a literal or a wire; a string: one of the ports with this string
            needs it), `default_counts` (a literal that equals the default will do), `setup` (the node reads the port in
            `setup` and is set up again when it changes), `extension` (Isaac Sim's node does not have the port), `couple`
            (ports of union type with the same couple resolve together), `component` (the port holds one number of the
            couple's tuple), `element` (the port holds one element of the couple's array).
    """
    return Field("inputs", default, facts=facts)


def Out(*, default: Any = MISSING, init: Literal[False] = False, **facts: Any) -> Any:
    """An output, reset to its default on stop. It accepts the same `facts` as `In`."""
    return Field("outputs", default, facts=facts)


def State(*, default: Any = MISSING, factory: Callable[[], Any] | None = None, init: Literal[False] = False) -> Any:
    """A value kept between calls of `compute`, reset to its default on stop and saved in checkpoints.

    Args:
        default: immutable value before the first compute.
        factory: returns a new mutable value for each node and each play.
        init: for type checkers; not an argument of the node's constructor.

    Raises:
        TypeError: neither `default` nor `factory` is given.
    """
    if default is MISSING and factory is None:
        raise TypeError("State needs a default or a factory; use Bound() for fields that `setup` assigns")
    return Field("state", default, factory)


def Bound(*, init: Literal[False] = False) -> Any:
    """A field that `setup` assigns, such as a handle from the context. Stop and `restore` do not change it.

    Args:
        init: for type checkers; not an argument of the node's constructor.
    """
    return Field("state")


_ANNOTATIONS: dict[Any, PortType] = {bool: PortType("bool"), int: PortType("int64"), float: PortType("double")}
_ANNOTATIONS |= {str: PortType("string"), Any: ANY}


def camel_case(field: str) -> str:
    """Return the OmniGraph name of a Python field: `linearVelocity` for `linear_velocity`."""
    head, *tail = field.split("_")
    return head + "".join(word[:1].upper() + word[1:] for word in tail)


def exec_port(name: str, field: ExecIn | ExecOut) -> Port:
    """Make the port of an execution field."""
    side: Side = "inputs" if isinstance(field, ExecIn) else "outputs"
    return Port(name, field.name or camel_case(name), side, EXECUTION, doc=field.doc, control=field.control)


def value_port(owner: str, name: str, field: Field, hint: Any) -> Port:
    """Make the port of a value field; the field's keyword `type` gives the port's type, or else its annotation does."""
    facts = dict(field.facts)
    explicit = facts.pop("type", None)
    port_type: PortType | UnionType | None = ANY if field.side == "state" else None
    if explicit:
        port_type = parse(explicit)
    elif port_type is None:
        extras = getattr(hint, "__metadata__", ())
        port_type = next((extra for extra in extras if isinstance(extra, PortType | UnionType)), None)
        if port_type is None:
            port_type = _ANNOTATIONS.get(hint)
    if port_type is None:
        raise TypeError(
            f"{owner}.{name}: no port type is known for {hint!r}; annotate it with one of graphengine.node.types"
        )
    ogn_name = facts.pop("name", "") or camel_case(name)
    facts["tokens"] = tuple(facts.get("tokens", ()))
    port = Port(name, ogn_name, field.side, port_type, **facts)
    if field.default is MISSING:
        zero = None if isinstance(port_type, UnionType) else port_type.zero
        return replace(port, default=zero, bound_in_setup=field.side == "state" and field.factory is None)
    if field.side == "state":
        if getattr(field.default, "__hash__", None) is None:
            kind = type(field.default).__name__
            raise TypeError(f"{owner}.{name}: default {field.default!r} is mutable; give factory={kind}")
        return replace(port, default=field.default)
    try:
        if isinstance(port_type, UnionType):
            return replace(port, default=first_that_takes(field.default, port_type.alternatives)[1])
        return replace(port, default=port.check(field.default))
    except (TypeError, ValueError) as error:
        raise TypeError(f"{owner}.{name}: default {field.default!r}: {error}") from None
