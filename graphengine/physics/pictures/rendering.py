"""Renders captured frames to arrays of colours, and of distances from the depth buffer of the same rendering pass.

MuJoCo's depth buffer contains floating-point numbers from 1 at the near plane to 0 at the far plane. For a distance d, the number
is near (far - d) / (d (far - near)), or (far - d) / (far - near) in a parallel projection.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphengine.descriptions.engine import mujoco
from graphengine.format.errors import RenderError
from graphengine.physics.pictures import opengl
from graphengine.physics.pictures.frame_capture import Lens, Shot

_SHADOW, _REFLECTION = mujoco.mjtRndFlag.mjRND_SHADOW.value, mujoco.mjtRndFlag.mjRND_REFLECTION.value
_SEGMENT, _ID_COLOUR = mujoco.mjtRndFlag.mjRND_SEGMENT.value, mujoco.mjtRndFlag.mjRND_IDCOLOR.value

SHADOW_MAP = 8192
"""Side of the shadow map of an image for users, texels."""


@dataclass(frozen=True, slots=True)
class Image:
    """A rendered image as arrays of shape (height, width, ...); row 0 is at the upper edge."""

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    """Distance along the optical axis, m; the distance of the sky is greater than the farthest visible distance."""
    segmentation: NDArray[np.int32] | None


class Renderer:
    """Draws shots of one model, in the thread in which it was created.

    Args:
        model: model of the shots.
        size: maximum width and height of an image, pixels.
        far: maximum distance of a lens's far plane, m; infinite floors extend to it.
        samples: samples per pixel for antialiasing; sensors use 0, because antialiasing triples the time.
        shadows: half the side of the square in which lights cast shadows, m; with 0, there are no shadows and reflections.
        shadow_map: side of the shadow map, texels.

    Raises:
        RenderError: the driver or MuJoCo fails.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        size: tuple[int, int],
        far: float,
        *,
        samples: int = 0,
        shadows: float = 0.0,
        shadow_map: int = SHADOW_MAP,
    ) -> None:
        self.model, self.size, self.far = model, size, far
        self._beautiful = shadows > 0
        drawn = copy.copy(model)  # whose settings are ours
        visual, extent = drawn.vis, drawn.stat.extent
        visual.global_.offwidth, visual.global_.offheight = size
        visual.quality.offsamples = samples
        visual.quality.shadowsize = shadow_map if shadows else 0
        visual.map.shadowclip = shadows / extent
        visual.map.zfar = max(visual.map.zfar, far / extent)
        drawn.tex_width[:] = drawn.tex_height[:] = 1
        with _refusals():
            self._context = mujoco.MjrContext(drawn, mujoco.mjtFontScale.mjFONTSCALE_100.value)
            # To make a context holds up all of Python, 0.3 s if Mesa has to scale textures in it. This does not.
            for texture in range(model.ntex):
                mujoco.mjr_uploadTexture(model, self._context, texture)
            mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._context)
        self._context.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR.value

    def fits(self, shot: Shot) -> bool:
        """Return whether this renderer can draw a shot: same model, and large enough in size and distance."""
        (width, height), far = shot.lens.size, shot.lens.far
        return shot.model is self.model and width <= self.size[0] and height <= self.size[1] and far <= self.far

    def draw(self, shot: Shot) -> Image:
        """Draw colours and depths in one pass, and the segmentation in another one if requested.

        Raises:
            RenderError: the driver or MuJoCo fails.
        """
        width, height = shot.lens.size
        rgb, buffer = np.empty((height, width, 3), np.uint8), np.empty((height, width), np.float32)
        flags = shot.scene.flags
        flags[_SHADOW] = flags[_REFLECTION] = self._beautiful
        with _refusals():
            self._pass(shot, rgb, buffer)
            segmentation = self._segmentation(shot) if shot.numbers is not None else None
        return Image(np.ascontiguousarray(rgb[::-1]), distances(shot.lens, buffer[::-1]), segmentation)

    def _pass(self, shot: Shot, rgb: NDArray[np.uint8], depth: NDArray[np.float32] | None) -> None:
        whole = mujoco.MjrRect(0, 0, *shot.lens.size)
        mujoco.mjr_render(whole, shot.scene, self._context)
        mujoco.mjr_readPixels(rgb, depth, whole, self._context)

    def _segmentation(self, shot: Shot) -> NDArray[np.int32]:
        """Render each segment of the scene in a colour that encodes its number, and return the segmentation IDs."""
        width, height = shot.lens.size
        colours, flags = np.empty((height, width, 3), np.uint8), shot.scene.flags
        flags[_SEGMENT] = flags[_ID_COLOUR] = True
        self._pass(shot, colours, None)
        flags[_SEGMENT] = flags[_ID_COLOUR] = False
        red, green, blue = (colours[::-1, :, channel].astype(np.int32) for channel in range(3))
        assert shot.numbers is not None
        numbers: NDArray[np.int32] = shot.numbers[red | green << 8 | blue << 16]
        return numbers

    def close(self) -> None:
        """Release all OpenGL resources."""
        self._context.free()


class RendererCache:
    """The present renderer and OpenGL context of a thread; a new model needs a new renderer, but no new context."""

    def __init__(self) -> None:
        self._opengl = ExitStack()
        self._renderer: Renderer | None = None

    def draw(self, shot: Shot, size: tuple[int, int], far: float, **settings: Any) -> Image:
        """Render a shot. After an error, renderer and context are destroyed, and created again for the next shot.

        Args:
            shot: shot to render.
            size: maximum width and height of later images, if a new renderer is needed, pixels.
            far: maximum distance of a later lens's far plane, m.
            settings: see `Renderer`; the same for all shots.

        Raises:
            RenderError: OpenGL does not work here, or rendering failed.
        """
        try:
            if self._renderer is None:
                self._opengl.enter_context(opengl.context())
            elif not self._renderer.fits(shot):
                self._renderer.close()
                self._renderer = None
            self._renderer = self._renderer or Renderer(shot.model, size, far, **settings)
            return self._renderer.draw(shot)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Destroy the renderer and the OpenGL context; a later shot creates them again."""
        if self._renderer is not None:
            self._renderer.close()
        self._renderer = None
        self._opengl.close()


def distances(lens: Lens, buffer: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return distances along the optical axis for values in the depth buffer, m.

    OpenGL stores matrices in single precision, and one entry of MuJoCo's projection matrix is a small difference of numbers near
    1. The error of this entry is up to 6e-8, which corresponds to 2 mm at 20 m. Here the entry is computed with the same
    precision. So the error cancels out.
    """
    near, far = np.float32(lens.near), np.float32(lens.far)
    metres: NDArray[np.float32]
    if lens.parallel:
        metres = buffer * (far - near)
        np.subtract(far, metres, out=metres)
    else:
        scale, shift = -(far + near) / (far - near), -2 * far * near / (far - near)  # as glFrustum has them
        metres = buffer + (np.float32(-0.5) * scale - np.float32(0.5))
        with np.errstate(divide="ignore"):  # a far plane 3e7 times as far as the near one is infinitely far
            np.divide(np.float32(-0.5) * shift, metres, out=metres)
    return metres


@contextmanager
def _refusals() -> Iterator[None]:
    try:
        yield
    except mujoco.FatalError as error:
        raise RenderError(f"MuJoCo cannot draw: {error}") from error
