"""Makes DDS types for ROS messages; with these types, Cyclone DDS announces type information and checks payloads."""

from __future__ import annotations

import dataclasses
import types
import weakref
from typing import Any

from cyclonedds.idl import IdlStruct
from cyclonedds.idl import types as idl
from cyclonedds.idl.annotations import final
from rosbags.interfaces import Nodetype

from graphengine.messages.definitions import DEFINITIONS, PLACEHOLDER, Definitions
from graphengine.messages.interfaces import SCALARS

_SCALARS: dict[str, Any] = {kind: getattr(idl, kind, None) for kind in SCALARS}
_SCALARS |= {"bool": bool, "byte": idl.uint8, "char": idl.uint8, "string": str}


def dds_name(message_type: str) -> str:
    """Return the DDS name of a message type: `nav_msgs::msg::dds_::Odometry_` for `nav_msgs/msg/Odometry`."""
    package, kind, name = message_type.split("/")
    return f"{package}::{kind}::dds_::{name}_"


def idl_type(message_type: str, definitions: Definitions = DEFINITIONS, *, is_call: bool = False) -> type[Any]:
    """Return a class that describes a message type to Cyclone DDS; the class is never instantiated.

    Args:
        message_type: ROS name of the type.
        definitions: message types.
        is_call: whether the message is a request or response, which begins with the `cdds_request_header` of
            rmw_cyclonedds_cpp.

    Raises:
        MessageTypeError: the type is unknown.
    """
    made = _made.setdefault(definitions, {})
    if (message_type, is_call) not in made:
        made[message_type, is_call] = _make(message_type, definitions, _HEADER if is_call else {})
    return made[message_type, is_call]


_made: weakref.WeakKeyDictionary[Definitions, dict[tuple[str, bool], type[Any]]] = weakref.WeakKeyDictionary()
_HEADER: dict[str, Any] = {"_client": idl.uint64, "_number": idl.int64}


def _make(message_type: str, definitions: Definitions, header: dict[str, Any]) -> type[Any]:
    # Cyclone DDS would refuse ROS 2's wide strings. It checks only the fields described here, and keeps all bytes.
    fields = [] if definitions.is_wide(message_type) else definitions.fields(message_type)
    annotations = header | {name: _idl(field, definitions) for name, field in fields or [PLACEHOLDER]}
    namespace = {"__annotations__": annotations, "__module__": __name__}
    name = dds_name(message_type)
    last, keywords = name.rpartition("::")[2], {"typename": name.replace("::", ".")}
    made = types.new_class(last, (IdlStruct,), keywords, lambda body: body.update(namespace))
    # ROS types are final in XTypes: an appendable type would have another encoding.
    described: type[Any] = final(dataclasses.dataclass(made))
    return described


def _idl(description: Any, definitions: Definitions) -> Any:
    kind, detail = description
    if kind == Nodetype.NAME:
        return idl_type(detail, definitions)
    if kind == Nodetype.BASE:
        name, bound = detail
        return idl.bounded_str[bound] if bound else _SCALARS[name]
    element, count = detail
    if kind == Nodetype.ARRAY:
        return idl.array[_idl(element, definitions), count]
    described = _idl(element, definitions)
    return idl.sequence[described, count] if count else idl.sequence[described]
