"""Nodes for viewports (`isaacsim.core.nodes`). Here a viewport has no window; it is only a named render product."""

from __future__ import annotations

from graphengine.devices.camera import LARGEST_PICTURE
from graphengine.node import Bound, Context, ExecIn, ExecOut, In, Node, Out, Token, UInt

DEFAULT = "Viewport"
"""Name of the viewport that exists from the start."""


class IsaacCreateViewport(Node, type="isaacsim.core.nodes.IsaacCreateViewport"):
    """Creates the viewport `name` if it does not exist. Use IsaacSetCameraOnRenderProduct to set its camera."""

    exec_in = ExecIn()
    name: Token = In(default="", setup=True, doc="name of the viewport; if empty, `viewportId` selects the name")
    viewport_id: UInt = In(default=0, setup=True, doc=f"number that is the name if `name` is empty; 0: {DEFAULT!r}")
    viewport: Token = Out(doc="name of the viewport")
    exec_out = ExecOut()

    title: str = Bound()

    def setup(self, context: Context) -> None:
        """Create the viewport and output its name; other nodes then find the viewport before the first tick."""
        self.title = self.name or (str(self.viewport_id) if self.viewport_id else DEFAULT)
        context.viewport(self.title, make=True)
        self.viewport = self.title

    def compute(self) -> None:
        """Output the name of the viewport."""
        self.viewport = self.title


class IsaacSetViewportResolution(Node, type="isaacsim.core.nodes.IsaacSetViewportResolution"):
    """Sets the image size of a viewport, at the start of the run and whenever an input changes."""

    exec_in = ExecIn()
    viewport: Token = In(default="", setup=True, doc=f"name of the viewport; if empty, {DEFAULT!r}")
    width: UInt = In(default=1280, ge=1, le=LARGEST_PICTURE, setup=True, unit="pixel")
    height: UInt = In(default=720, ge=1, le=LARGEST_PICTURE, setup=True, unit="pixel")
    exec_out = ExecOut()

    def setup(self, context: Context) -> None:
        """Set the image size of the viewport; the engine calls `setup` again when an input changes."""
        context.viewport(self.viewport or DEFAULT, (self.width, self.height))

    def compute(self) -> None:
        """Do nothing: `setup` sets the image size."""


class IsaacGetViewportRenderProduct(Node, type="isaacsim.core.nodes.IsaacGetViewportRenderProduct"):
    """Outputs the path of a viewport's render product, for camera helper nodes."""

    exec_in = ExecIn()
    viewport: Token = In(default="", setup=True, doc="name of the viewport, from IsaacCreateViewport")
    render_product_path: Token = Out()
    exec_out = ExecOut()

    path: str = Bound()

    def setup(self, context: Context) -> None:
        """Look up the render product and output its path; helper nodes then know the path before the first tick."""
        self.path = self.render_product_path = context.viewport(self.viewport)

    def compute(self) -> None:
        """Output the path of the render product."""
        self.render_product_path = self.path
