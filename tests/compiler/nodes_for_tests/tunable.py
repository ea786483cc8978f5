"""A node with inputs of many types, for the tests of parameters."""

from __future__ import annotations

from typing import Any

from graphengine.node.node_class import Node
from graphengine.node.port import ExecIn, In
from graphengine.node.types import (
    Double3s,
    Doubles,
    Quaterniond,
    String,
    Target,
    Token,
    Tokens,
    UChar,
    UChars,
    UInt64,
    Vector3d,
)


class Tunable(Node, type="test.Tunable"):
    """Has inputs and does nothing."""

    exec_in = ExecIn()
    gain: float = In(default=1.0, ge=0.0, le=2.0, doc="what it multiplies with", unit="m/s")
    share: float = In(default=0.5, gt=0.0, le=1.0)
    enabled: bool = In(default=True)
    level: UChar = In(default=3)
    number: int = In(default=0)
    big: UInt64 = In(default=0)
    mode: Token = In(default="slow", tokens=("slow", "fast"))
    title: String = In(default="")
    axis: Vector3d = In(default=(1.0, 0.0, 0.0))
    turn: Quaterniond = In(default=(0.0, 0.0, 0.0, 1.0))
    weights: Doubles = In()
    names: Tokens = In()
    image: UChars = In()
    points: Double3s = In()
    prim: Target = In()
    topic: Token = In(default="chatter", setup=True)
    anything: Any = In(default=None)

    def compute(self) -> None:
        """Do nothing."""
