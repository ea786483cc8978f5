"""Render products: what helpers find a camera or lidar by (`isaacsim.core.nodes`)."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from graphengine.devices.camera import Camera
from graphengine.node import (
    Bound,
    Context,
    ExecIn,
    ExecOut,
    Fire,
    Float,
    Floats,
    In,
    Node,
    Out,
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

    path: str = Bound()

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


_CAMERA = "camera:of a render product"
"""What is read and written here, in the words of the lint that asks for an order."""


class IsaacSetCameraOnRenderProduct(Node, type="isaacsim.core.nodes.IsaacSetCameraOnRenderProduct"):
    """Lets a render product show what another camera sees, in the render product's size."""

    exec_in = ExecIn()
    render_product_path: Token = In(required=True, setup=True, doc="from IsaacCreateRenderProduct")
    camera_prim: Target = In(required=True, setup=True, doc="prim of the camera")
    exec_out = ExecOut()

    exchange: Callable[[], None] = Bound()

    def setup(self, context: Context) -> None:
        """Bind both cameras."""
        self.exchange = context.exchange_camera(self.render_product_path, self.camera_prim[0])

    def writes(self) -> Iterable[str]:
        """The camera."""
        return (_CAMERA,)

    def compute(self) -> None:
        """Exchange the camera, for all that have the render product's."""
        self.exchange()


HORIZONTAL_APERTURE = 20.955
"""USD's default. Only the ratio of focal length and aperture counts: it is the field of view."""


class IsaacReadCameraInfo(Node, type="isaacsim.core.nodes.IsaacReadCameraInfo", volatile=True):
    """Size and lens of the camera behind a render product, in USD's terms: a pinhole with its optical axis in the middle."""

    render_product_path: Token = In(required=True, setup=True, doc="from IsaacCreateRenderProduct")
    width: UInt = Out(unit="pixel")
    height: UInt = Out(unit="pixel")
    focal_length: Float = Out(unit="mm", doc="fx is width times focal length / horizontal aperture")
    horizontal_aperture: Float = Out(unit="mm")
    vertical_aperture: Float = Out(unit="mm", doc="as its pixels are square")
    horizontal_offset: Float = Out(unit="mm", doc="0: of the aperture's middle from the optical axis")
    vertical_offset: Float = Out(unit="mm", doc="0: of the aperture's middle from the optical axis")
    projection_type: Token = Out(doc="pinhole")
    camera_fisheye_params: Floats = Out(doc="none")
    physical_distortion_model: Token = Out(doc="plumb_bob")
    physical_distortion_coefficients: Floats = Out(doc="five zeros")

    camera: Camera = Bound()

    def setup(self, context: Context) -> None:
        """Bind the camera."""
        self.camera = context.device(Camera, self.render_product_path)

    def reads(self) -> Iterable[str]:
        """The camera."""
        return (_CAMERA,)

    def compute(self) -> None:
        """Read the camera."""
        self.width, self.height = self.camera.size
        self.horizontal_aperture = HORIZONTAL_APERTURE
        self.vertical_aperture = HORIZONTAL_APERTURE * self.height / self.width
        self.focal_length = self.camera.intrinsics[0] * HORIZONTAL_APERTURE / self.width
        self.projection_type, self.physical_distortion_model = "pinhole", "plumb_bob"
        self.physical_distortion_coefficients = _NO_DISTORTION


_NO_DISTORTION = np.zeros(5, np.float32)
_NO_DISTORTION.setflags(write=False)
