"""Render products: paths by which helper nodes find a camera or lidar (`isaacsim.core.nodes`)."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from graphengine.devices.camera import Camera
from graphengine.node import Bound, Context, ExecIn, ExecOut, Fire, In, Node, Out
from graphengine.node.types import Float, Floats, Target, Token, UInt, read_only


class IsaacCreateRenderProduct(Node, type="isaacsim.core.nodes.IsaacCreateRenderProduct", gated=True):
    """Creates a render product of a camera or lidar; helper nodes take its path."""

    exec_in = ExecIn()
    width: UInt = In(default=1280, setup=True, unit="pixel")
    height: UInt = In(default=720, setup=True, unit="pixel")
    camera_prim: Target = In(required=True, setup=True, doc="prim of the camera or lidar")
    enabled: bool = In(default=True, doc="false: execOut does not fire")
    render_product_prim: Target = In(setup=True, doc="path of an existing render product to output instead")
    render_product_path: Token = Out(doc="path for helper nodes")
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
"""What is read and written here, in the words of the lint that asks for an order."""


class IsaacSetCameraOnRenderProduct(Node, type="isaacsim.core.nodes.IsaacSetCameraOnRenderProduct"):
    """Switches a render product to another camera and keeps the render product's size."""

    exec_in = ExecIn()
    render_product_path: Token = In(required=True, setup=True, doc="from IsaacCreateRenderProduct")
    camera_prim: Target = In(required=True, setup=True, doc="prim of the camera")
    exec_out = ExecOut()

    exchange: Callable[[], None] = Bound()

    def setup(self, context: Context) -> None:
        """Find the render product and the new camera."""
        self.exchange = context.exchange_camera(self.render_product_path, self.camera_prim[0])

    def writes(self) -> Iterable[str]:
        """The camera."""
        return (_CAMERA,)

    def compute(self) -> None:
        """Switch all nodes that use the render product to the new camera."""
        self.exchange()


HORIZONTAL_APERTURE = 20.955
"""USD's default, mm. Only the ratio of focal length to aperture matters: it sets the field of view."""


class IsaacReadCameraInfo(Node, type="isaacsim.core.nodes.IsaacReadCameraInfo", volatile=True):
    """Reads size and lens of a render product's camera, in USD's terms: a pinhole with a centred optical axis."""

    render_product_path: Token = In(required=True, setup=True, doc="from IsaacCreateRenderProduct")
    width: UInt = Out(unit="pixel")
    height: UInt = Out(unit="pixel")
    focal_length: Float = Out(unit="mm", doc="fx is width * focalLength / horizontalAperture")
    horizontal_aperture: Float = Out(unit="mm")
    vertical_aperture: Float = Out(unit="mm", doc="horizontalAperture * height / width: pixels are square")
    horizontal_offset: Float = Out(unit="mm", doc="always 0: offset of the aperture's centre from the optical axis")
    vertical_offset: Float = Out(unit="mm", doc="always 0: offset of the aperture's centre from the optical axis")
    projection_type: Token = Out(doc="always pinhole")
    camera_fisheye_params: Floats = Out(doc="always empty")
    physical_distortion_model: Token = Out(doc="always plumb_bob")
    physical_distortion_coefficients: Floats = Out(doc="always five zeros")

    camera: Camera = Bound()

    def setup(self, context: Context) -> None:
        """Bind the camera."""
        self.camera = context.device(Camera, self.render_product_path)

    def reads(self) -> Iterable[str]:
        """The camera."""
        return (_CAMERA,)

    def compute(self) -> None:
        """Read size and lens of the camera."""
        self.width, self.height = self.camera.size
        self.horizontal_aperture = HORIZONTAL_APERTURE
        self.vertical_aperture = HORIZONTAL_APERTURE * self.height / self.width
        self.focal_length = self.camera.intrinsics[0] * HORIZONTAL_APERTURE / self.width
        self.projection_type, self.physical_distortion_model = "pinhole", "plumb_bob"
        self.physical_distortion_coefficients = _NO_DISTORTION


_NO_DISTORTION = read_only(np.zeros(5, np.float32))
