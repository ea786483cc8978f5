"""Stubs of the classes in `omni.graph.core` that describe attribute types and node types."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from graphengine.node import PortType

BaseDataType = enum.IntEnum(
    "BaseDataType", "UNKNOWN BOOL UCHAR INT UINT INT64 UINT64 HALF FLOAT DOUBLE TOKEN RELATIONSHIP", start=0
)
"""Stub of `og.BaseDataType`: the base type of a value."""


class AttributeRole(enum.IntEnum):
    """Stub of `og.AttributeRole`: the meaning of a value, such as a position or colour."""

    NONE = 0
    VECTOR = 1
    NORMAL = 2
    POSITION = 3
    COLOR = 4
    TEXCOORD = 5
    QUATERNION = 6
    TRANSFORM = 7
    FRAME = 8
    TIMECODE = 9
    TEXT = 10
    EXECUTION = 13
    MATRIX = 14
    OBJECT_ID = 15
    BUNDLE = 16
    PATH = 17
    TARGET = 20
    UNKNOWN = 21


class AttributePortType(enum.IntEnum):
    """Stub of `og.AttributePortType`: whether an attribute is an input, an output or a state."""

    ATTRIBUTE_PORT_TYPE_INPUT = 0
    ATTRIBUTE_PORT_TYPE_OUTPUT = 1
    ATTRIBUTE_PORT_TYPE_STATE = 2
    ATTRIBUTE_PORT_TYPE_UNKNOWN = 3


_OGN_NAMES = {"position": "point", "quaternion": "quat", "matrix": "matrixd", "text": "string", "object_id": "objectId"}
"""Names of roles in `.ogn` files, by lower-case member name of `AttributeRole`, where both differ."""
_OF_LETTERS = ("string", "path")
"""Roles of text: such a value has array depth 1, but its type name has no `[]`."""
_BASES = ("timecode", "execution", "objectId", "bundle", "target", *_OF_LETTERS)
"""Roles whose names replace the base type in a type name."""


@dataclass(unsafe_hash=True)
class Type:
    """Stub of `og.Type`: base type, number of components, array depth and role of a value."""

    base_type: BaseDataType
    tuple_count: int = 1
    array_depth: int = 0
    role: AttributeRole = AttributeRole.NONE

    def get_ogn_type_name(self) -> str:
        """Return the name of the type in `.ogn` files, such as `double[3]`."""
        base = "target" if self.base_type == BaseDataType.RELATIONSHIP else BaseDataType(self.base_type).name.lower()
        role = AttributeRole(self.role).name.lower()
        role = _OGN_NAMES.get(role, role)
        array = self.array_depth > (role in _OF_LETTERS)
        return str(PortType(role if role in _BASES else base, self.tuple_count, array, role))

    __str__ = get_ogn_type_name


class AttributeType:
    """Stub of `og.AttributeType`, with the only function that scripts use."""

    @staticmethod
    def type_from_ogn_type_name(name: str) -> str:
        """Return the name unchanged, because these stubs accept type names as types."""
        return name


TYPES = (Type, BaseDataType, AttributeRole, AttributePortType, AttributeType)
"""Type classes that become members of the stub of `omni.graph.core`."""


class NodeType(str):
    """Stub of `og.NodeType`: a string that contains the name of the node type."""

    __slots__ = ()

    def get_node_type(self) -> str:
        """Return the name of the node type."""
        return str(self)

    def is_valid(self) -> bool:
        """Return True, because the node type is assumed to exist."""
        return True
