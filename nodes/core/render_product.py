"""Nodes for render products (`isaacsim.core.nodes`). Helper nodes find a sensor by the path of its render product."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from graphengine.devices.camera import Camera
from graphengine.node import Bound, Context, ExecIn, ExecOut, Fire, In, Node, Out
from graphengine.node.types import Float, Floats, Target, Token, UInt, read_only


class IsaacCreateRenderProduct(Node, type="isaacsim.core.nodes.IsaacCreateRenderProduct", gated=True):
    """Creates a render product of a camera, lidar or radar. Helper nodes find the sensor by the path of the render product."""

    exec_in = ExecIn()
    width: UInt = In(default=1280, setup=True, unit="pixel")
    height: UInt = In(default=720, setup=True, unit="pixel")
    camera_prim: Target = In(required=True, setup=True, doc="prim of the camera, lidar or radar")
    enabled: bool = In(default=True, doc="false: `execOut` does not fire")
    render_product_prim: Target = In(setup=True, doc="existing render product to output; if empty, it is created")
    render_product_path: Token = Out(doc="path of the render product, for helper nodes")
    exec_out = ExecOut()

    path: str = Bound()

    def setup(self, context: Context) -> None:
        """Create the render product and output its path; helper nodes then know the path before the first tick."""
        if self.render_product_prim:
            self.path = self.render_product_prim[0]
        else:
            self.path = context.render_product(self.camera_prim[0], self.width, self.height)
        self.render_product_path = self.path

    def compute(self) -> Fire:
        """Fire if `enabled` is true, and output the path again."""
        if not self.enabled:
            return None
        self.render_product_path = self.path
        return self.exec_out


_CAMERA = "camera:of a render product"
"""Resource key that stands for the cameras of all render products.

The lint for unordered reads and writes prints the key, without its colon, in its message.
"""


class IsaacSetCameraOnRenderProduct(Node, type="isaacsim.core.nodes.IsaacSetCameraOnRenderProduct"):
    """Switches a render product to another camera. The width and height of the render product stay the same."""

    exec_in = ExecIn()
    render_product_path: Token = In(required=True, setup=True, doc="render product, from IsaacCreateRenderProduct")
    camera_prim: Target = In(required=True, setup=True, doc="prim of the camera to switch to")
    exec_out = ExecOut()

    exchange: Callable[[], None] = Bound()

    def setup(self, context: Context) -> None:
        """Look up the render product and the new camera."""
        self.exchange = context.exchange_camera(self.render_product_path, self.camera_prim[0])

    def writes(self) -> Iterable[str]:
        """Return the resource key of the cameras of all render products."""
        return (_CAMERA,)

    def compute(self) -> None:
        """Switch the render product to the new camera, for all nodes that use this render product."""
        self.exchange()


HORIZONTAL_APERTURE = 20.955
"""Horizontal aperture of all cameras, mm: USD's default. The ratio of focal length to aperture alone sets the field of view."""


class IsaacReadCameraInfo(Node, type="isaacsim.core.nodes.IsaacReadCameraInfo", volatile=True):
    """Outputs the image size, focal length and aperture of a render product's camera, as USD defines them for pinhole cameras."""

    render_product_path: Token = In(required=True, setup=True, doc="render product, from IsaacCreateRenderProduct")
    width: UInt = Out(unit="pixel")
    height: UInt = Out(unit="pixel")
    focal_length: Float = Out(unit="mm", doc="in pixels, it is `width` * `focalLength` / `horizontalAperture`")
    horizontal_aperture: Float = Out(unit="mm", doc=f"always {HORIZONTAL_APERTURE}, USD's default")
    vertical_aperture: Float = Out(unit="mm", doc="`horizontalAperture` * `height` / `width`: pixels are square")
    horizontal_offset: Float = Out(unit="mm", doc="horizontal offset of the aperture from the optical axis; always 0")
    vertical_offset: Float = Out(unit="mm", doc="vertical offset of the aperture from the optical axis; always 0")
    projection_type: Token = Out(doc="always pinhole")
    camera_fisheye_params: Floats = Out(doc="always empty, because cameras are pinhole cameras")
    physical_distortion_model: Token = Out(doc="always plumb_bob")
    physical_distortion_coefficients: Floats = Out(doc="always five zeros: no distortion")

    camera: Camera = Bound()

    def setup(self, context: Context) -> None:
        """Look up the camera of the render product at `renderProductPath`."""
        self.camera = context.device(Camera, self.render_product_path)

    def reads(self) -> Iterable[str]:
        """Return the resource key of the cameras of all render products."""
        return (_CAMERA,)

    def compute(self) -> None:
        """Output the current image size and focal length of the camera, and the apertures."""
        self.width, self.height = self.camera.size
        self.horizontal_aperture = HORIZONTAL_APERTURE
        self.vertical_aperture = HORIZONTAL_APERTURE * self.height / self.width
        self.focal_length = self.camera.intrinsics[0] * HORIZONTAL_APERTURE / self.width
        self.projection_type, self.physical_distortion_model = "pinhole", "plumb_bob"
        self.physical_distortion_coefficients = _NO_DISTORTION


_NO_DISTORTION = read_only(np.zeros(5, np.float32))
