"""The field specifiers with which a node class declares its ports, and the resulting descriptions of ports."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal, TypeVar, overload

import numpy as np

from graphengine.node.types import ANY, EXECUTION, PortType, UnionType, coerce, first_that_takes, parse

T = TypeVar("T")
Side = Literal["inputs", "outputs", "state"]

Fire = int | None
"""Return type of `compute` in a gated node: the ExecOut ports to fire, joined by `|`, or None to fire no port."""
Pushes = Generator[int, None, None]
"""Return type of a pusher's `compute`, which yields the ExecOut ports to fire."""

MISSING: Any = object()
"""Default of a field without a default."""

_TOLD = 20
"""Maximum number of legal strings that a message lists."""


@dataclass(frozen=True, slots=True)
class Port:
    """Description of one port of a node type."""

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
    """True if the port needs a literal or a wire. A string names a group of ports: one of them needs a literal or a wire."""
    default_counts: bool = False
    """Whether a literal that equals the default satisfies `required`; normally it does not."""
    unset: bool = False
    """Whether the default, zero, is out of the bounds on purpose and means that the port is not set."""
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
        """Whether this is an execution port, not a value port."""
        return isinstance(self.type, PortType) and self.type.base == EXECUTION.base

    @property
    def constraint(self) -> str:
        """The legal values as text, such as `≥ 0 and ≤ 1` or `one of a, b`; empty if every value of the type is legal."""
        if self.tokens:
            return "one of " + ", ".join(self.tokens)
        signs = (("≥", self.ge), (">", self.gt), ("≤", self.le), ("<", self.lt))
        return " and ".join(f"{sign} {bound:g}" for sign, bound in signs if bound is not None)

    @property
    def is_bounded(self) -> bool:
        """Whether the port has bounds for numbers."""
        return any(bound is not None for bound in (self.ge, self.gt, self.le, self.lt))

    def check(self, value: Any, *, recorded: bool = False) -> Any:
        """Check a value that a file or command sets, and return its Python representation for the port's type.

        Args:
            value: the value; for a union port, already converted to one of its types.
            recorded: whether the value comes from a recording; then it need not be within the bounds, which may be newer.

        Raises:
            TypeError: the value has the wrong type.
            ValueError: the value is out of range, or is not one of the legal strings.
        """
        if not isinstance(self.type, UnionType):
            value = coerce(value, self.type)
        if (wrong := self.refusal(value)) and not (recorded and self.is_bounded):
            raise ValueError(wrong)
        return value

    def refusal(self, value: Any) -> str:
        """Return a text that states the legal values if `value`, which has the port's type, is not legal; otherwise empty."""
        if self.tokens and value not in self.tokens:
            more = f", … ({len(self.tokens) - _TOLD} more)" if len(self.tokens) > _TOLD else ""
            return f"expected one of {', '.join(self.tokens[:_TOLD])}{more}"
        if isinstance(value, int | float) and not isinstance(value, bool):
            if self.is_bounded:
                return "" if self._allows(value) else f"expected a value {self.constraint}"
            return "expected a number other than NaN" if math.isnan(value) and isinstance(self.type, PortType) else ""
        numbers = np.ravel(value).tolist() if self.is_bounded else ()
        for index, number in enumerate(numbers):
            if not self._allows(number):
                return f"expected values {self.constraint}, got {number} at [{index}]"
        return ""

    def is_missing(self, value: Any) -> bool:
        """Return whether the port is required and `value` is an empty list or text, which counts as no value."""
        return self.required is True and isinstance(value, tuple | str) and not value and not self.default_counts

    def _allows(self, number: float) -> bool:
        """Return whether a number is within the bounds; NaN never is."""
        low_enough = (self.le is None or number <= self.le) and (self.lt is None or number < self.lt)
        high_enough = (self.ge is None or number >= self.ge) and (self.gt is None or number > self.gt)
        return low_enough and high_enough


@dataclass(eq=False)
class Field:
    """A field in the body of a node class. When the class is created, a port replaces the field."""

    side: Side
    default: Any = MISSING
    factory: Callable[[], Any] | None = None
    facts: Mapping[str, Any] = field(default_factory=dict)


class ExecIn:
    """An execution input. During `compute`, the attribute is the number of firings that led to this call."""

    def __init__(self, *, name: str = "", doc: str = "", control: bool = False) -> None:
        self.name, self.doc, self.control = name, doc, control

    if TYPE_CHECKING:

        def __get__(self, instance: object, owner: type) -> int: ...

        def __set__(self, instance: object, value: int) -> None: ...


class ExecOut:
    """An execution output. To fire it, `compute` returns or yields it."""

    def __init__(self, *, name: str = "", doc: str = "") -> None:
        self.name, self.doc, self.control = name, doc, False

    if TYPE_CHECKING:

        def __get__(self, instance: object, owner: type) -> int: ...


@overload
def In(*, default: T, **facts: Any) -> T: ...
@overload
def In(**facts: Any) -> Any: ...
def In(*, default: Any = MISSING, **facts: Any) -> Any:
    """Return the declaration of an input, to be assigned to a field in the body of a node class.

    Args:
        default: value of the input if it has neither a literal nor a wire. Without a default, this value is the zero of the
            port's type, and type checkers require the input in the constructor.
        facts: properties of the port, each with one of these keywords:

            - `doc`: description of the port for users.
            - `unit`: unit of the value, such as `m/s`.
            - `ge`, `gt`, `le`, `lt`: bounds of a number, or of each number of an array. Values that a file or a command sets are
              checked, values from wires are not. A single number must not be NaN, even if the port has no bounds.
            - `tokens`: legal strings, if not all are legal.
            - `name`: OmniGraph name of the port; by default, the field's name in camel case.
            - `type`: OmniGraph type of the port, or its name; by default, the annotation gives the type.
            - `required`: True if the port needs a literal or a wire. A string names a group of ports: at least one port of
              the group needs a literal or a wire.
            - `default_counts`: whether a literal that equals the default satisfies `required`.
            - `unset`: pass True for an input without `default` whose bounds exclude zero. The initial value zero then means
              that the input is not set. A required input does not need this keyword.
            - `setup`: whether the node reads the port in `setup`; when the value changes, the node is set up again.
            - `extension`: whether the port is missing from the node in Isaac Sim.
            - `couple`: union ports with the same string resolve to the same type.
            - `component`: whether the port has the type of one component if the ports with the same `couple` have a tuple type.
            - `element`: whether the port has the type of one element if the ports with the same `couple` have an array type.
    """
    return Field("inputs", default, facts=facts)


def Out(*, default: Any = MISSING, init: Literal[False] = False, **facts: Any) -> Any:
    """Declare an output port, and return the declaration. When the simulation stops, the output gets its default again.

    Args:
        default: initial value; without a default, the zero of the port's type.
        init: do not pass it; it tells type checkers that an output is not an argument of the node's constructor.
        facts: the keywords of `In`.
    """
    return Field("outputs", default, facts=facts)


def State(*, default: Any = MISSING, factory: Callable[[], Any] | None = None, init: Literal[False] = False) -> Any:
    """Return the declaration of a state field, which keeps its value between calls of `compute`.

    A stop resets the field to its initial value; checkpoints contain its value.

    Args:
        default: initial value, which must be immutable.
        factory: function that returns a new initial value; for mutable values such as lists.
        init: do not pass it; it tells type checkers that a state field is not an argument of the node's constructor.

    Raises:
        TypeError: neither `default` nor `factory` is given.
    """
    if default is MISSING and factory is None:
        raise TypeError("State needs a default or a factory; use Bound() for fields that `setup` assigns")
    return Field("state", default, factory)


def Bound(*, init: Literal[False] = False) -> Any:
    """Return the declaration of a field that `setup` assigns, such as a handle from the context.

    A stop does not reset the field, and checkpoints do not contain it.

    Args:
        init: do not pass it; it tells type checkers that a bound field is not an argument of the node's constructor.
    """
    return Field("state")


_ANNOTATIONS: dict[Any, PortType] = {bool: PortType("bool"), int: PortType("int64"), float: PortType("double")}
_ANNOTATIONS |= {str: PortType("string"), Any: ANY}


def camel_case(field: str) -> str:
    """Return the OmniGraph name of a Python field: `linearVelocity` for `linear_velocity`."""
    head, *tail = field.split("_")
    return head + "".join(word[:1].upper() + word[1:] for word in tail)


def exec_port(name: str, field: ExecIn | ExecOut) -> Port:
    """Return the port for an ExecIn or ExecOut field."""
    side: Side = "inputs" if isinstance(field, ExecIn) else "outputs"
    return Port(name, field.name or camel_case(name), side, EXECUTION, doc=field.doc, control=field.control)


def value_port(owner: str, name: str, field: Field, hint: Any) -> Port:
    """Return the port for an In, Out, State or Bound field.

    Args:
        owner: name of the node class, for error messages.
        name: Python name of the field.
        field: the field.
        hint: annotation of the field; it gives the port's type unless the field has the keyword `type`.

    Raises:
        TypeError: the port's type is unknown, or the default is not legal.
        ValueError: the keyword `type` is not the name of a port type.
    """
    facts = dict(field.facts)
    explicit = facts.pop("type", None)
    port_type: PortType | UnionType | None = ANY if field.side == "state" else None
    if explicit:
        port_type = parse(explicit) if isinstance(explicit, str) else explicit
    elif port_type is None:
        extras = getattr(hint, "__metadata__", ())
        found = (extra for extra in extras if isinstance(extra, PortType | UnionType))
        port_type = next(found, None) or _ANNOTATIONS.get(hint)
    if port_type is None:
        remedy = "annotate the field with a type of graphengine.node.types"
        raise TypeError(f"{owner}.{name}: no port type is known for {hint!r}; {remedy}")
    ogn_name = facts.pop("name", "") or camel_case(name)
    facts["tokens"] = tuple(facts.get("tokens", ()))
    port = Port(name, ogn_name, field.side, port_type, **facts)
    if field.default is MISSING:
        zero = None if isinstance(port_type, UnionType) else port_type.zero
        return replace(port, default=zero, bound_in_setup=field.side == "state" and field.factory is None)
    if field.side == "state":
        if getattr(field.default, "__hash__", None) is None:
            kind = type(field.default).__name__
            raise TypeError(f"{owner}.{name}: default {field.default!r} is mutable; write factory={kind} instead")
        return replace(port, default=field.default)
    try:
        if isinstance(port_type, UnionType):
            return replace(port, default=first_that_takes(field.default, port_type.alternatives)[1])
        return replace(port, default=port.check(field.default))
    except (TypeError, ValueError) as error:
        raise TypeError(f"{owner}.{name}: default {field.default!r}: {error}") from None
