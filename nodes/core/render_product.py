"""Render products: what helpers find a camera or lidar by (`isaacsim.core.nodes`)."""

from __future__ import annotations

from graphengine.context import Context
from graphengine.node import ExecIn, ExecOut, Fire, In, Node, Out, State
from graphengine.types import (
    Target,
    Token,
    UInt,
)


class IsaacCreateRenderProduct(Node, type="isaacsim.core.nodes.IsaacCreateRenderProduct", gated=True):
    """Binds a camera or lidar prim to a path that helpers take."""

    exec_in = ExecIn()
    width: UInt = In(default=1280, setup=True, unit="pixel")
    height: UInt = In(default=720, setup=True, unit="pixel")
    camera_prim: Target = In(required=True, setup=True, doc="prim of the camera or lidar")
    enabled: bool = In(default=True, doc="when false, nothing fires")
    render_product_prim: Target = In(setup=True, doc="a render product to use as it is")
    render_product_path: Token = Out(doc="what helpers take")
    exec_out = ExecOut()

    path: str = State()

    def setup(self, context: Context) -> None:
        """Make the path, so that helpers know it before the first tick."""
        if self.render_product_prim:
            self.path = self.render_product_prim[0]
        else:
            self.path = context.render_product(self.camera_prim[0], self.width, self.height)
        self.render_product_path = self.path

    def compute(self) -> Fire:
        """Hand the path on."""
        if not self.enabled:
            return None
        self.render_product_path = self.path
        return self.exec_out
