"""Units of the stage (`isaacsim.core.nodes`), which are metres."""

from __future__ import annotations

from typing import Any

from graphengine.node import In, Node, Out, Token
from graphengine.nodes.data.unions import NUMERICS


class OgnIsaacScaleToFromStageUnit(Node, type="isaacsim.core.nodes.OgnIsaacScaleToFromStageUnit"):
    """Converts lengths from metres to stage units or back; here both are equal."""

    conversion: Token = In(
        default="Convert to stage units",
        tokens=("Convert to stage units", "Convert to meters"),
        doc="direction; both leave the value unchanged",
    )
    value: Any = In(type=NUMERICS, couple="length", required=True, unit="m", doc="number, tuple or array")
    result: Any = Out(type=NUMERICS, couple="length", unit="m")

    def compute(self) -> None:
        """Copy the value."""
        self.result = self.value
