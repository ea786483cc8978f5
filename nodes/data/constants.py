"""Constants (`omni.graph.nodes`). A constant has no output: wires start at its input `value`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graphengine.node import In, Node, Out
from graphengine.node.node_class import NodeMeta

_TYPES = {"Bool": "bool", "UChar": "uchar", "Int": "int", "Int64": "int64", "UInt": "uint", "UInt64": "uint64"}
_TYPES |= {"Half": "half", "Float": "float", "Double": "double", "Timecode": "timecode"}
_TYPES |= {
    f"{base}{count}": f"{base.lower()}[{count}]" for base in ("Int", "Half", "Float", "Double") for count in (2, 3, 4)
}
_ROLES = {"Color": (3, 4), "Normal": (3,), "Point": (3,), "TexCoord": (2, 3), "Vector": (3,)}
_TYPES |= {
    f"{role}{count}{bits}": f"{role.lower()}{bits}[{count}]"
    for role, counts in _ROLES.items()
    for count in counts
    for bits in "dfh"
}
_TYPES |= {f"Quat{bits}": f"quat{bits}[4]" for bits in "dfh"}
_TYPES |= {f"Matrix{size}d": f"matrixd[{size}]" for size in (2, 3, 4)} | {"Frame": "frame[4]"}
_TYPES |= {"Path": "path", "String": "string", "Target": "target", "Token": "token"}
"""OmniGraph's type of each constant, by the end of the node type's name."""


def _constant(suffix: str, port_type: str) -> type[Node]:
    """The node type of a constant, which has only an input."""
    # A quaternion that the file does not set is no rotation.
    initial = {"default": (0.0, 0.0, 0.0, 0.0)} if suffix.startswith("Quat") else {}
    namespace = {
        "__module__": __name__,
        "__qualname__": f"Constant{suffix}",
        "__doc__": f"A value of type {port_type} that other nodes read.",
        "value": In(type=port_type, doc="value; wires start here: `NODE.inputs:value -> ...`", **initial),
    }
    made: Any = NodeMeta(f"Constant{suffix}", (Node,), namespace, type=f"omni.graph.nodes.Constant{suffix}")
    return made  # type: ignore[no-any-return]


globals().update({f"Constant{suffix}": _constant(suffix, port_type) for suffix, port_type in _TYPES.items()})


class ConstantPi(Node, type="omni.graph.nodes.ConstantPi"):
    """A multiple of pi."""

    factor: float = In(default=1.0, doc="factor by which to multiply pi")
    value: float = Out(doc="`factor` * pi")

    def compute(self) -> None:
        """Multiply the factor by pi."""
        self.value = self.factor * math.pi


class ConstantE(Node, type="omni.graph.nodes.ConstantE"):
    """A power of Euler's number."""

    exponent: float = In(default=1.0, doc="power to which e is raised")
    value: float = Out(doc="e to the power of `exponent`")

    def compute(self) -> None:
        """Raise e to the exponent."""
        with np.errstate(over="ignore"):  # what is too large is infinite
            self.value = float(np.exp(self.exponent))
