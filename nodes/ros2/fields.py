"""Creates ports for the fields of a message, as OmniGraph's generic ROS 2 nodes do.

The port of a nested field is named by its path, such as `header:frame_id`. A field of type `byte` or `char` becomes a `uchar`
port, another integer of up to 32 bits an `int` or `uint` port, and a string a `token` port. Arrays of these types become array
ports. An array of messages becomes an array of tokens, each with one message as JSON.
"""

from __future__ import annotations

import functools
import itertools
import json
import operator
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from graphengine.format import bounded_json
from graphengine.messages.definitions import Definitions, dtype_of
from graphengine.messages.interfaces import (
    TEXTS,
    Description,
    MessageTypeError,
    element_of,
    message_of,
    signed_byte,
    written,
)
from graphengine.messages.message_text import to_plain
from graphengine.messages.message_validation import find_fault
from graphengine.messages.messages import MessageError
from graphengine.messages.plain import from_plain
from graphengine.node import BadValueError, ContextError, In, Node, PortType

MAX_PORTS = 2000
"""Maximum number of ports for the fields of one message type; the largest message type of ROS 2 Jazzy needs 38."""

PORT_TYPES = dict.fromkeys(("byte", "char"), "uchar") | dict.fromkeys(("string", "wstring"), "token")
PORT_TYPES |= dict.fromkeys(("int8", "int16", "int32"), "int") | dict.fromkeys(("uint8", "uint16", "uint32"), "uint")
PORT_TYPES |= {"bool": "bool", "int64": "int64", "uint64": "uint64", "float32": "float", "float64": "double"}
"""OmniGraph type of the port for a field, by the ROS type of the field."""
_NARROW = {
    "int8": (-(2**7), 2**7 - 1),
    "uint8": (0, 2**8 - 1),
    "int16": (-(2**15), 2**15 - 1),
    "uint16": (0, 2**16 - 1),
}
"""Lowest and highest value of each ROS integer type that has fewer bits than the type of its port."""


class Leaf:
    """A message field that is represented by one port: a number, a string or an array.

    Args:
        path: ROS names of the nested fields that lead from the message to this field.
        attributes: Python names of the same fields.
        kind: type of the field.
        definitions: definitions of all known message types.
        part: `Request` or `Response` if the message is that part of a service, `Goal`, `Result` or `Feedback` if it is that part
            of an action; empty for the message of a topic.
    """

    def __init__(
        self, path: Sequence[str], attributes: Sequence[str], kind: Description, definitions: Definitions, part: str
    ) -> None:
        inner = element_of(kind)
        self.name = ":".join((part, *path) if part else path)
        """OmniGraph name of the port."""
        self.attribute = "__".join((part.lower() or "message", *path))
        """Name of the port's attribute in the node class.

        It is unique: ROS names have no double underscore, and no other attribute of a node begins with this prefix."""
        self.of = operator.attrgetter(".".join(attributes))
        """Function that returns the field's value in a message."""
        self.kind = kind
        self.definitions = definitions
        self.is_array = inner is not kind
        self.element: str = "" if message_of(inner) else inner[1][0]
        """ROS type of the field's value, or of the elements if the field is an array; empty for an array of messages."""
        is_bounded = self.element in TEXTS and inner[1][1] > 0
        self.plain = not self.is_array and self.element != "byte" and not is_bounded
        """Whether `from_port` returns the port's value unchanged and unchecked; the encoder checks it later."""

    @functools.cached_property
    def port_dtype(self) -> Any:
        """The numpy dtype of the port; only for arrays of numbers."""
        return PortType(PORT_TYPES[self.element]).dtype

    def port(self, make: Callable[..., Any], name: str, initial: Any) -> Any:
        """Return a new port for this field.

        Args:
            make: `In` or `Out`.
            name: OmniGraph name of the port.
            initial: value of the field in a new message: the default of the port.
        """
        facts: dict[str, Any] = {"name": name, "doc": written(self.kind)}
        facts["type"] = PORT_TYPES.get(self.element, "token") + ("[]" if self.is_array else "")
        if self.element in _NARROW and not self.is_array:
            facts["ge"], facts["le"] = _NARROW[self.element]
        return make(default=self.to_port(initial), **facts)

    def to_port(self, value: Any) -> Any:
        """Convert the field's value in a message to a value for the port."""
        if not self.is_array:
            return value & 0xFF if self.element == "byte" else value
        if not self.element:
            return tuple(json.dumps(to_plain(item, self.definitions)) for item in value)
        if self.element in TEXTS:
            return tuple(value)
        if self.element == "byte":
            return value.view(np.uint8)
        return value.astype(self.port_dtype, copy=False)

    def from_port(self, value: Any) -> Any:
        """Convert the port's value to a value for the message.

        Raises:
            MessageError: the value does not fit the field. The range of a single number is checked later, by the encoder.
        """
        if self.plain:
            return value
        if not self.is_array:
            value = signed_byte(value) if self.element == "byte" else value
        elif not self.element:
            value = [self._message(text, f"{self.name}[{index}]") for index, text in enumerate(value)]
        else:
            value = list(value) if self.element in TEXTS else self._numbers(value)
        fault = find_fault(value, self.kind, self.name, self.definitions.fields)
        if fault:
            raise MessageError(fault)
        return value

    def takes(self, value: Any) -> bool:
        """Return whether the port's value fits the field."""
        try:
            return not find_fault(self.from_port(value), self.kind, self.name, self.definitions.fields)
        except MessageError:
            return False

    def _numbers(self, value: NDArray[Any]) -> NDArray[Any]:
        if self.element == "byte":
            return np.ascontiguousarray(value).view(np.int8)
        low, high = _NARROW.get(self.element, (0, 0))
        if high and len(value) and (value.max() > high or (low and value.min() < low)):
            wrong = next(number for number in value.tolist() if not low <= number <= high)
            raise MessageError(f"{self.name} contains {wrong}, which is out of the range of {self.element}")
        return np.ascontiguousarray(value, dtype_of(self.element))

    def _message(self, text: str, place: str) -> Any:
        try:
            data = bounded_json.parse(text)
        except ValueError as error:
            raise MessageError(f"{place} is not JSON: {error}") from None
        return from_plain(data, message_of(element_of(self.kind)), self.definitions, place)


@dataclass(frozen=True)
class Layout:
    """The mapping between the ports of a node and the fields of a message.

    Two layouts are equal if they have the same message class and part.

    Args:
        message_class: class of the message.
        definitions: definitions of all known message types.
        part: `Request`, `Response`, `Goal`, `Result` or `Feedback` if the message is that part of a service or action;
            prefix of the port names. Empty for the message of a topic.
    """

    message_class: type[Any]
    definitions: Definitions = field(compare=False, repr=False)
    part: str = ""

    @property
    def message_type(self) -> str:
        """ROS name of the message type, such as `geometry_msgs/msg/Twist`."""
        return str(self.message_class.__msgtype__)

    @property
    def type_name(self) -> str:
        """ROS name of the message, service or action type, such as `std_srvs/srv/SetBool`."""
        return self.message_type.removesuffix(f"_{self.part}")

    @functools.cached_property
    def leaves(self) -> tuple[Leaf, ...]:
        """All fields that have a port, including fields of nested messages, in the order of the message definition."""
        fields = _leaves(self.message_type, (), (), self.definitions, self.part)
        found = tuple(itertools.islice(fields, MAX_PORTS + 1))
        if len(found) > MAX_PORTS:
            raise MessageTypeError(
                f"{self.message_type} has more than {MAX_PORTS} fields, which is too many for ports",
                self.message_type.rpartition("/")[2],
            )
        return found

    def ports(self, make: Callable[..., Any], taken: Container[str] = ()) -> dict[str, Any]:
        """Return a dict with a new port for each leaf; the keys are attribute names of the node class.

        Args:
            make: `In` or `Out`.
            taken: names of the node's other ports; if a leaf has one of these names, its port gets the prefix `message:`.
        """
        initial, found = self.definitions.initial(self.message_type), dict[str, Any]()
        for leaf in self.leaves:
            name = f"message:{leaf.name}" if leaf.name in taken else leaf.name
            found[leaf.attribute] = leaf.port(make, name, leaf.of(initial))
        return found

    def read(self, node: Node) -> Any:
        """Return a message with the values of the node's ports.

        Raises:
            MessageError: the value of a port does not fit its field.
        """
        return self._make(iter([leaf.from_port(getattr(node, leaf.attribute)) for leaf in self.leaves]))

    def send(self, node: Node, publish: Callable[[Any], object]) -> None:
        """Build a message from the values of the node's ports, and call `publish` with it.

        Raises:
            BadValueError: the value of a port does not fit its field.
        """
        try:
            publish(self.read(node))
        except MessageError as error:
            values = {leaf: getattr(node, leaf.attribute) for leaf in self.leaves}
            wrong = [leaf for leaf, value in values.items() if not leaf.takes(value)]
            ports = ", ".join(type(node).fields[leaf.attribute].name for leaf in wrong or values)
            raise BadValueError(ports, values[wrong[0]] if wrong else list(values.values())) from error

    def write(self, node: Node, message: Any) -> None:
        """Set the node's ports to the values of a message."""
        for leaf in self.leaves:
            setattr(node, leaf.attribute, leaf.to_port(leaf.of(message)))

    def check(self, node: Node) -> None:
        """Check that the value of each port of the node fits its field.

        Raises:
            ContextError: the value of a port does not fit its field.
        """
        for leaf in self.leaves:
            value = getattr(node, leaf.attribute)
            try:
                leaf.from_port(value)
            except MessageError as error:
                raise ContextError(str(error), value) from None

    @functools.cached_property
    def _make(self) -> Callable[[Iterator[Any]], Any]:
        return _maker(self.message_type, self.definitions)


def _maker(message_type: str, definitions: Definitions) -> Callable[[Iterator[Any]], Any]:
    """Return a function that builds a message from an iterator over the values of its leaves."""
    message_class = definitions.message_class(message_type)
    nested = [message_of(kind) for _, kind in definitions.fields(message_type)]
    parts = [_maker(part, definitions) if part else next for part in nested]
    return lambda values: message_class(*[part(values) for part in parts])


class MissingMessageError(ContextError):
    """The graph file does not name the message, service or action type of a node."""

    code = "G208"


class FieldNode(Node):
    """Base of nodes that have a port for each field of a message, service or action type.

    The inputs `messagePackage`, `messageSubfolder` and `messageName` name the type; a subclass declares them. The graph file must
    set them to literals, because the ports of fields are created before wires are read.
    """

    folder: ClassVar[Literal["msg", "srv", "action"]]
    """Kind of the type, and the default of `messageSubfolder`."""
    parts: ClassVar[Mapping[str, Callable[..., Any]]]
    """For each part of the type whose fields are ports of the node: `In` or `Out`.

    The parts are `request` and `response` of a service, `goal`, `result` and `feedback` of an action, and `message` of a topic.
    `dynamic_ports` stores the layout of each part in the class attribute of this name.
    """
    message_package: str
    message_subfolder: str
    message_name: str

    @classmethod
    def dynamic_ports(cls, literals: Mapping[str, Any], definitions: Definitions) -> Mapping[str, Any]:
        """Return the layouts of the node's parts, and a port for each of their fields.

        Raises:
            MissingMessageError: the graph file does not set `messagePackage` or `messageName`.
            MessageTypeError: the type is unknown.
        """
        layouts, found = _find_layouts(_named(literals, cls.folder), cls.folder, definitions), dict[str, Any]()
        inputs = {port.name for port in cls.fields.values() if port.side == "inputs"}
        for part, make in cls.parts.items():
            found |= {part: layouts[part], **layouts[part].ports(make, inputs if make is In else ())}
        return found

    def bind(self) -> str:
        """Check the values of the field inputs, and return the type that the inputs name, such as std_srvs/srv/SetBool.

        Raises:
            ContextError: the node's ports were created for another type, or the value of an input does not fit its field.
        """
        named = f"{self.message_package}/{self.message_subfolder}/{self.message_name}"
        layouts = {part: getattr(self, part, None) for part in self.parts}
        made_of = next((layout.type_name for layout in layouts.values() if layout), None)
        if made_of != named:
            raise ContextError(
                f"the ports are those of {made_of or 'no message'}, but the inputs name {named}",
                self.message_name,
                "write messagePackage and messageName below `inputs:`; --set takes effect only after the ports are created",
            )
        for part, layout in layouts.items():
            if layout and self.parts[part] is In:
                layout.check(self)
        return named


def _find_layouts(name: str, folder: str, definitions: Definitions) -> dict[str, Layout]:
    """Return the layout of each part of a type, such as the layouts `request` and `response` of a service type."""
    kinds: tuple[str, ...] = (name,)
    if folder != "msg":
        kinds = definitions.service_parts(name) if folder == "srv" else definitions.action_parts(name)
    layouts = (Layout(definitions.message_class(kind), definitions, kind[len(name) + 1 :]) for kind in kinds)
    return {layout.part.lower() or "message": layout for layout in layouts}


def _named(literals: Mapping[str, Any], subfolder: str) -> str:
    """Return the name of the type that the literals give; without a `messageSubfolder`, `subfolder` is used."""
    words = {"messageSubfolder": subfolder, **literals}
    names = [words.get(name) for name in ("messagePackage", "messageSubfolder", "messageName")]
    if None in names or "" in names:
        text = "the inputs name no message type, but the node's ports are the fields of a message"
        remedy = (
            "write messagePackage and messageName below `inputs:`; a wire takes effect only after the ports are created"
        )
        raise MissingMessageError(text, None, remedy)
    return "/".join(map(str, names))


def _leaves(
    message_type: str, path: tuple[str, ...], attributes: tuple[str, ...], definitions: Definitions, part: str
) -> Iterator[Leaf]:
    names = (name for name, _ in definitions.definition(message_type).fields)
    for name, (attribute, kind) in zip(names, definitions.fields(message_type), strict=True):
        to, by = (*path, name), (*attributes, attribute)
        inner = message_of(kind)
        if inner:
            yield from _leaves(inner, to, by, definitions, part)
        else:
            yield Leaf(to, by, kind, definitions, part)
