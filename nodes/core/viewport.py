"""Viewports, which consist only of a render product here (`isaacsim.core.nodes`)."""

from __future__ import annotations

from graphengine.node import Bound, Context, ExecIn, ExecOut, In, Node, Out, Token, UInt

DEFAULT = "Viewport"
"""Name of the viewport that exists from the start."""


class IsaacCreateViewport(Node, type="isaacsim.core.nodes.IsaacCreateViewport"):
    """Creates a viewport, or uses the one that has this name. IsaacSetCameraOnRenderProduct sets its camera."""

    exec_in = ExecIn()
    name: Token = In(default="", setup=True, doc="name of the viewport; empty to use `viewportId`")
    viewport_id: UInt = In(default=0, setup=True, doc=f"number of the viewport if `name` is empty; 0 is {DEFAULT!r}")
    viewport: Token = Out(doc="name of the viewport")
    exec_out = ExecOut()

    title: str = Bound()

    def setup(self, context: Context) -> None:
        """Create the viewport, so that other nodes find it before the first tick."""
        self.title = self.name or (str(self.viewport_id) if self.viewport_id else DEFAULT)
        context.viewport(self.title, make=True)
        self.viewport = self.title

    def compute(self) -> None:
        """Fire; `setup` has set the name."""
        self.viewport = self.title


class IsaacSetViewportResolution(Node, type="isaacsim.core.nodes.IsaacSetViewportResolution"):
    """Sets the size of a viewport's pictures, at the start of the run and whenever an input changes."""

    exec_in = ExecIn()
    viewport: Token = In(default="", setup=True, doc=f"name of the viewport; empty for {DEFAULT!r}")
    width: UInt = In(default=1280, setup=True, unit="pixel")
    height: UInt = In(default=720, setup=True, unit="pixel")
    exec_out = ExecOut()

    def setup(self, context: Context) -> None:
        """Set the size; the engine calls this again when an input changes."""
        context.viewport(self.viewport or DEFAULT, (self.width, self.height))

    def compute(self) -> None:
        """Fire; `setup` has set the size."""


class IsaacGetViewportRenderProduct(Node, type="isaacsim.core.nodes.IsaacGetViewportRenderProduct"):
    """Outputs the render product of a viewport, for camera helper nodes."""

    exec_in = ExecIn()
    viewport: Token = In(default="", setup=True, doc="name of the viewport, from IsaacCreateViewport")
    render_product_path: Token = Out()
    exec_out = ExecOut()

    path: str = Bound()

    def setup(self, context: Context) -> None:
        """Find the render product, so that helper nodes know its path before the first tick."""
        self.path = self.render_product_path = context.viewport(self.viewport)

    def compute(self) -> None:
        """Fire; `setup` has set the path."""
        self.render_product_path = self.path
