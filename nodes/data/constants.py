"""Constants (`omni.graph.nodes`): wires begin at the input `value` of such a node."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graphengine.node import In, Node, Out
from graphengine.node.node_class import NodeMeta


def _constant(suffix: str, port_type: str, **facts: Any) -> type[Node]:
    """The node type of a constant, which has only an input."""
    namespace = {
        "__module__": __name__,
        "__qualname__": f"Constant{suffix}",
        "__doc__": f"A value of type {port_type} that other nodes read.",
        "value": In(type=port_type, doc="wires begin here: `NODE.inputs:value -> ...`", **facts),
    }
    made: Any = NodeMeta(f"Constant{suffix}", (Node,), namespace, type=f"omni.graph.nodes.Constant{suffix}")
    return made  # type: ignore[no-any-return]


_NO_ROTATION_YET = (0.0, 0.0, 0.0, 0.0)
"""What a quaternion is before the file sets it; it is no rotation."""

ConstantBool = _constant("Bool", "bool")
ConstantUChar = _constant("UChar", "uchar")
ConstantInt = _constant("Int", "int")
ConstantInt2 = _constant("Int2", "int[2]")
ConstantInt3 = _constant("Int3", "int[3]")
ConstantInt4 = _constant("Int4", "int[4]")
ConstantInt64 = _constant("Int64", "int64")
ConstantUInt = _constant("UInt", "uint")
ConstantUInt64 = _constant("UInt64", "uint64")

ConstantHalf = _constant("Half", "half")
ConstantHalf2 = _constant("Half2", "half[2]")
ConstantHalf3 = _constant("Half3", "half[3]")
ConstantHalf4 = _constant("Half4", "half[4]")
ConstantFloat = _constant("Float", "float")
ConstantFloat2 = _constant("Float2", "float[2]")
ConstantFloat3 = _constant("Float3", "float[3]")
ConstantFloat4 = _constant("Float4", "float[4]")
ConstantDouble = _constant("Double", "double")
ConstantDouble2 = _constant("Double2", "double[2]")
ConstantDouble3 = _constant("Double3", "double[3]")
ConstantDouble4 = _constant("Double4", "double[4]")
ConstantTimecode = _constant("Timecode", "timecode")

ConstantColor3d = _constant("Color3d", "colord[3]")
ConstantColor3f = _constant("Color3f", "colorf[3]")
ConstantColor3h = _constant("Color3h", "colorh[3]")
ConstantColor4d = _constant("Color4d", "colord[4]")
ConstantColor4f = _constant("Color4f", "colorf[4]")
ConstantColor4h = _constant("Color4h", "colorh[4]")
ConstantNormal3d = _constant("Normal3d", "normald[3]")
ConstantNormal3f = _constant("Normal3f", "normalf[3]")
ConstantNormal3h = _constant("Normal3h", "normalh[3]")
ConstantPoint3d = _constant("Point3d", "pointd[3]")
ConstantPoint3f = _constant("Point3f", "pointf[3]")
ConstantPoint3h = _constant("Point3h", "pointh[3]")
ConstantTexCoord2d = _constant("TexCoord2d", "texcoordd[2]")
ConstantTexCoord2f = _constant("TexCoord2f", "texcoordf[2]")
ConstantTexCoord2h = _constant("TexCoord2h", "texcoordh[2]")
ConstantTexCoord3d = _constant("TexCoord3d", "texcoordd[3]")
ConstantTexCoord3f = _constant("TexCoord3f", "texcoordf[3]")
ConstantTexCoord3h = _constant("TexCoord3h", "texcoordh[3]")
ConstantVector3d = _constant("Vector3d", "vectord[3]")
ConstantVector3f = _constant("Vector3f", "vectorf[3]")
ConstantVector3h = _constant("Vector3h", "vectorh[3]")

ConstantQuatd = _constant("Quatd", "quatd[4]", default=_NO_ROTATION_YET)
ConstantQuatf = _constant("Quatf", "quatf[4]", default=_NO_ROTATION_YET)
ConstantQuath = _constant("Quath", "quath[4]", default=_NO_ROTATION_YET)
ConstantMatrix2d = _constant("Matrix2d", "matrixd[2]")
ConstantMatrix3d = _constant("Matrix3d", "matrixd[3]")
ConstantMatrix4d = _constant("Matrix4d", "matrixd[4]")
ConstantFrame = _constant("Frame", "frame[4]")

ConstantPath = _constant("Path", "path")
ConstantString = _constant("String", "string")
ConstantTarget = _constant("Target", "target")
ConstantToken = _constant("Token", "token")


class ConstantPi(Node, type="omni.graph.nodes.ConstantPi"):
    """A multiple of pi."""

    factor: float = In(default=1.0, doc="multiple of pi")
    value: float = Out(doc="factor * pi")

    def compute(self) -> None:
        """Multiply the factor by pi."""
        self.value = self.factor * math.pi


class ConstantE(Node, type="omni.graph.nodes.ConstantE"):
    """A power of Euler's number."""

    exponent: float = In(default=1.0, doc="exponent of the power")
    value: float = Out(doc="e to the exponent")

    def compute(self) -> None:
        """Raise e to the exponent."""
        with np.errstate(over="ignore"):  # what is too large is infinite
            self.value = float(np.exp(self.exponent))
