"""Nodes that hold constants (`omni.graph.nodes`).

Only ConstantPi and ConstantE have an output. The other constants have none: wires start at their input `value`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graphengine.node import In, Node, Out
from graphengine.node.node_class import NodeMeta

_TYPES = {"Bool": "bool", "UChar": "uchar", "Int": "int", "Int64": "int64", "UInt": "uint", "UInt64": "uint64"}
_TYPES |= {"Half": "half", "Float": "float", "Double": "double", "Timecode": "timecode"}
_BASES = ("Int", "Half", "Float", "Double")
_TYPES |= {f"{base}{count}": f"{base.lower()}[{count}]" for base in _BASES for count in (2, 3, 4)}
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
"""OmniGraph type of each constant; the key is the name of the node type without `Constant`."""


def _constant(suffix: str, port_type: str) -> type[Node]:
    """Return the node type of a constant; its only port is the input `value`."""
    # OmniGraph's default is (0, 0, 0, 0), which is not a rotation.
    initial = {"default": (0.0, 0.0, 0.0, 0.0)} if suffix.startswith("Quat") else {}
    namespace = {
        "__module__": __name__,
        "__qualname__": f"Constant{suffix}",
        "__doc__": f"Holds a value of type {port_type} for other nodes.",
        "value": In(type=port_type, doc="constant; wires start here: `NODE.inputs:value -> ...`", **initial),
    }
    made: Any = NodeMeta(f"Constant{suffix}", (Node,), namespace, type=f"omni.graph.nodes.Constant{suffix}")
    return made  # type: ignore[no-any-return]


globals().update({f"Constant{suffix}": _constant(suffix, port_type) for suffix, port_type in _TYPES.items()})


class ConstantPi(Node, type="omni.graph.nodes.ConstantPi"):
    """Multiplies pi by a factor."""

    factor: float = In(default=1.0, doc="factor by which to multiply pi")
    value: float = Out(doc="`factor` * pi")

    def compute(self) -> None:
        """Set `value` to `factor` * pi."""
        self.value = self.factor * math.pi


class ConstantE(Node, type="omni.graph.nodes.ConstantE"):
    """Raises Euler's number e to a power."""

    exponent: float = In(default=1.0, doc="exponent of e")
    value: float = Out(doc="e to the power of `exponent`")

    def compute(self) -> None:
        """Set `value` to e to the power of `exponent`, or to infinity if that is too large for a double."""
        with np.errstate(over="ignore"):  # what is too large is infinite
            self.value = float(np.exp(self.exponent))
