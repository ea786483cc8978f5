"""MJCF elements of converted worlds: attributes as text, and the root element around bodies and meshes."""

from __future__ import annotations

from collections.abc import Sequence

from graphengine.descriptions.files.xml import Element
from graphengine.devices.rotation import Pose, Vector3
from graphengine.format.diagnostics import Span

_COMPILER = {"angle": "radian", "autolimits": "true", "balanceinertia": "true"}
_STATISTIC = {"extent": "1", "center": "0 0 0.5", "meansize": "0.2"}
"""Attributes of `<statistic>`, by which MuJoCo scales its rendering; the same as in the built-in worlds."""
AMBIENT = "0.4 0.4 0.4"
"""Colour of the light without direction, if a world does not give it."""
BACKGROUND = "0.7 0.7 0.7"
"""Colour of the sky, if a world does not give it."""


def written(*values: float) -> str:
    """Return numbers as text with full precision, separated by spaces; -0.0 becomes 0.0."""
    return " ".join(repr(value + 0.0) for value in values)


def placed(pose: Pose, **more: str) -> dict[str, str]:
    """Return the MJCF attributes `pos` and `quat` of a pose, preceded by the given other attributes."""
    x, y, z, w = pose[1]
    return {**more, "pos": written(*pose[0]), "quat": written(w, x, y, z)}


def world_element(
    name: str,
    gravity: Vector3,
    assets: Sequence[Element],
    body: Element,
    others: Sequence[Element] = (),
    ambient: str = AMBIENT,
    background: str = BACKGROUND,
) -> Element:
    """Return the root element of a world.

    Args:
        name: name of the model.
        gravity: acceleration, m/s2.
        assets: meshes.
        body: `worldbody`.
        others: other children of the root.
        ambient: colour of the light without direction.
        background: colour of the sky.
    """
    span = body.span
    sky = {"name": "sky", "type": "skybox", "builtin": "gradient", "width": "64", "height": "384"}
    sky |= {"rgb1": background, "rgb2": background}
    parts = [
        Element("compiler", dict(_COMPILER), span),
        Element("option", {"gravity": written(*gravity)}, span),
        Element("statistic", dict(_STATISTIC), span),
        _visual(ambient, span),
        *others,
        Element("asset", {}, span, [Element("texture", sky, span), *assets]),
        body,
    ]
    return Element("mujoco", {"model": name}, span, parts)


def _visual(ambient: str, span: Span) -> Element:
    children = [
        Element("map", {"znear": "0.02", "zfar": "120"}, span),
        Element("quality", {"offsamples": "0"}, span),
        Element("global", {"offwidth": "1280", "offheight": "800"}, span),
        Element("headlight", {"ambient": ambient, "diffuse": "0.2 0.2 0.2", "specular": "0 0 0"}, span),
    ]
    return Element("visual", {}, span, children)
