"""Types as in `omni.graph.core`: of values, by base type, count, array depth and role, and of nodes."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

BaseDataType = enum.IntEnum(
    "BaseDataType", "UNKNOWN BOOL UCHAR INT UINT INT64 UINT64 HALF FLOAT DOUBLE TOKEN RELATIONSHIP", start=0
)
"""What a value is made of."""


class AttributeRole(enum.IntEnum):
    """What a value means."""

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
    """On which side of a node an attribute is."""

    ATTRIBUTE_PORT_TYPE_INPUT = 0
    ATTRIBUTE_PORT_TYPE_OUTPUT = 1
    ATTRIBUTE_PORT_TYPE_STATE = 2
    ATTRIBUTE_PORT_TYPE_UNKNOWN = 3


_WITH_PRECISION = {
    AttributeRole.VECTOR: "vector",
    AttributeRole.NORMAL: "normal",
    AttributeRole.POSITION: "point",
    AttributeRole.COLOR: "color",
    AttributeRole.TEXCOORD: "texcoord",
    AttributeRole.QUATERNION: "quat",
}
_MATRICES = {AttributeRole.MATRIX: "matrixd", AttributeRole.FRAME: "frame", AttributeRole.TRANSFORM: "transform"}
_WHOLE = {
    AttributeRole.TIMECODE: "timecode",
    AttributeRole.EXECUTION: "execution",
    AttributeRole.OBJECT_ID: "objectId",
    AttributeRole.BUNDLE: "bundle",
    AttributeRole.TARGET: "target",
    AttributeRole.TEXT: "string",
    AttributeRole.PATH: "path",
}
_OF_LETTERS = (AttributeRole.TEXT, AttributeRole.PATH)
"""Roles whose values are arrays of letters."""


@dataclass(unsafe_hash=True)
class Type:
    """`og.Type`."""

    base_type: BaseDataType
    tuple_count: int = 1
    array_depth: int = 0
    role: AttributeRole = AttributeRole.NONE

    def get_ogn_type_name(self) -> str:
        """As `.ogn` files write it, such as `double[3]`."""
        depth = self.array_depth - (self.role in _OF_LETTERS)
        return f"{self._element()}{'[]' if depth > 0 else ''}"

    __str__ = get_ogn_type_name

    def _element(self) -> str:
        base = "target" if self.base_type == BaseDataType.RELATIONSHIP else BaseDataType(self.base_type).name.lower()
        if self.role in _WHOLE:
            return _WHOLE[self.role]
        if self.role in _MATRICES:
            return f"{_MATRICES[self.role]}[{math.isqrt(self.tuple_count)}]"
        name = f"{_WITH_PRECISION[self.role]}{base[0]}" if self.role in _WITH_PRECISION else base
        return f"{name}[{self.tuple_count}]" if self.tuple_count > 1 else name


class AttributeType:
    """`og.AttributeType`, of which scripts use one function."""

    @staticmethod
    def type_from_ogn_type_name(name: str) -> str:
        """The type of a name, which the name is here."""
        return name


class NodeType(str):
    """A type of nodes, which is its name as well."""

    __slots__ = ()

    def get_node_type(self) -> str:
        """Its name."""
        return str(self)

    def is_valid(self) -> bool:
        """Whether there is one."""
        return True
