"""Render products: paths by which helper nodes find a camera, lidar or radar (`isaacsim.core.nodes`)."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from graphengine.devices.camera import Camera
from graphengine.node import Bound, Context, ExecIn, ExecOut, Fire, In, Node, Out
from graphengine.node.types import Float, Floats, Target, Token, UInt, read_only


class IsaacCreateRenderProduct(Node, type="isaacsim.core.nodes.IsaacCreateRenderProduct", gated=True):
    """Creates a render product of a camera, lidar or radar; helper nodes find the sensor by its path."""

    exec_in = ExecIn()
    width: UInt = In(default=1280, setup=True, unit="pixel")
    height: UInt = In(default=720, setup=True, unit="pixel")
    camera_prim: Target = In(required=True, setup=True, doc="prim of the camera, lidar or radar")
    enabled: bool = In(default=True, doc="false: `execOut` does not fire")
    render_product_prim: Target = In(setup=True, doc="existing render product to use instead of a new one")
    render_product_path: Token = Out(doc="path of the render product, for helper nodes")
    exec_out = ExecOut()

    path: str = Bound()

    def setup(self, context: Context) -> None:
        """Create the render product, so that helper nodes know its path before the first tick."""
        if self.render_product_prim:
            self.path = self.render_product_prim[0]
        else:
            self.path = context.render_product(self.camera_prim[0], self.width, self.height)
        self.render_product_path = self.path

    def compute(self) -> Fire:
        """Fire if enabled; `setup` has set the path."""
        if not self.enabled:
            return None
        self.render_product_path = self.path
        return self.exec_out


_CAMERA = "camera:of a render product"
"""Resource key of the cameras of all render products, worded for the message of the lint that asks for an order."""


class IsaacSetCameraOnRenderProduct(Node, type="isaacsim.core.nodes.IsaacSetCameraOnRenderProduct"):
    """Switches a render product to another camera; its width and height stay the same."""

    exec_in = ExecIn()
    render_product_path: Token = In(
        required=True, setup=True, doc="path of the render product, from IsaacCreateRenderProduct"
    )
    camera_prim: Target = In(required=True, setup=True, doc="prim of the camera to switch to")
    exec_out = ExecOut()

    exchange: Callable[[], None] = Bound()

    def setup(self, context: Context) -> None:
        """Find the render product and the new camera."""
        self.exchange = context.exchange_camera(self.render_product_path, self.camera_prim[0])

    def writes(self) -> Iterable[str]:
        """Return the resource key of the cameras of all render products."""
        return (_CAMERA,)

    def compute(self) -> None:
        """Switch all nodes that use the render product to the new camera."""
        self.exchange()


HORIZONTAL_APERTURE = 20.955
"""Horizontal aperture, mm: USD's default. Only the ratio of focal length to aperture sets the field of view."""


class IsaacReadCameraInfo(Node, type="isaacsim.core.nodes.IsaacReadCameraInfo", volatile=True):
    """Reads image size, focal length and aperture of a render product's camera, which is a pinhole camera as in USD."""

    render_product_path: Token = In(
        required=True, setup=True, doc="path of the render product, from IsaacCreateRenderProduct"
    )
    width: UInt = Out(unit="pixel")
    height: UInt = Out(unit="pixel")
    focal_length: Float = Out(unit="mm", doc="focal length; fx is `width` * `focalLength` / `horizontalAperture`")
    horizontal_aperture: Float = Out(unit="mm", doc=f"always {HORIZONTAL_APERTURE}, USD's default")
    vertical_aperture: Float = Out(unit="mm", doc="`horizontalAperture` * `height` / `width`: pixels are square")
    horizontal_offset: Float = Out(unit="mm", doc="offset of the aperture's centre from the optical axis; always 0")
    vertical_offset: Float = Out(unit="mm", doc="offset of the aperture's centre from the optical axis; always 0")
    projection_type: Token = Out(doc="always pinhole")
    camera_fisheye_params: Floats = Out(doc="always empty")
    physical_distortion_model: Token = Out(doc="always plumb_bob")
    physical_distortion_coefficients: Floats = Out(doc="always five zeros")

    camera: Camera = Bound()

    def setup(self, context: Context) -> None:
        """Bind the camera."""
        self.camera = context.device(Camera, self.render_product_path)

    def reads(self) -> Iterable[str]:
        """Return the resource key of the cameras of all render products."""
        return (_CAMERA,)

    def compute(self) -> None:
        """Read image size and focal length of the camera, and derive the apertures."""
        self.width, self.height = self.camera.size
        self.horizontal_aperture = HORIZONTAL_APERTURE
        self.vertical_aperture = HORIZONTAL_APERTURE * self.height / self.width
        self.focal_length = self.camera.intrinsics[0] * HORIZONTAL_APERTURE / self.width
        self.projection_type, self.physical_distortion_model = "pinhole", "plumb_bob"
        self.physical_distortion_coefficients = _NO_DISTORTION


_NO_DISTORTION = read_only(np.zeros(5, np.float32))
