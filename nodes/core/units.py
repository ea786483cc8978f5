"""The node that converts lengths between metres and stage units (`isaacsim.core.nodes`)."""

from __future__ import annotations

from typing import Any

from graphengine.node import In, Node, Out, Token
from graphengine.nodes.data.unions import NUMERICS


class OgnIsaacScaleToFromStageUnit(Node, type="isaacsim.core.nodes.OgnIsaacScaleToFromStageUnit"):
    """Converts lengths from metres to stage units or back; in graphengine, a stage unit is always one metre."""

    conversion: Token = In(
        default="Convert to stage units",
        tokens=("Convert to stage units", "Convert to meters"),
        doc="direction of the conversion; the value is unchanged in both directions",
    )
    value: Any = In(type=NUMERICS, couple="length", required=True, unit="m", doc="number, tuple or array to convert")
    result: Any = Out(type=NUMERICS, couple="length", unit="m")

    def compute(self) -> None:
        """Copy `value` to `result`."""
        self.result = self.value
