"""Converts lights, ambient light and sky of SDF worlds to MJCF."""

from __future__ import annotations

import math

from graphengine.descriptions.files.xml import Element, numbers
from graphengine.descriptions.sdf.sdf_frames import SdfFrame, place_of
from graphengine.descriptions.sdf.sdf_values import SdfError, flag_at, number_at, numbers_at, text_at
from graphengine.descriptions.worlds.mjcf_elements import written
from graphengine.devices.rotation import Vector3, rotate
from graphengine.format.wording import printable


def light_of(light: Element, frame: SdfFrame) -> Element:
    """Return the MJCF light for an SDF light.

    Args:
        light: SDF `<light>` element.
        frame: frame of the world that contains the light.

    Raises:
        SdfError: the type of the light is unknown, or a value is not a number.
    """
    position, rotation = place_of(light, frame)
    x, y, z = numbers_at(light, "direction", default=(0.0, 0.0, -1.0))
    kind = light.get("type") or "point"
    if kind not in ("point", "directional", "spot"):
        raise SdfError(f"unknown light type {printable(kind[:40])!r}", light.place("type"))
    strength = number_at(light, "intensity", default=1.0)
    attributes = {
        "type": kind,
        "pos": written(*position),
        "dir": written(*rotate(rotation, (x, y, z))) if x or y or z else "0 0 -1",
        "diffuse": _colour(light, "diffuse", (1.0, 1.0, 1.0), strength),
        "specular": _colour(light, "specular", (0.1, 0.1, 0.1), strength),
        "castshadow": str(flag_at(light, "cast_shadows") is True).lower(),
    }
    if name := light.get("name"):
        attributes["name"] = name
    if kind != "directional" and light.first("attenuation") is not None:
        terms = (("constant", 1.0), ("linear", 0.0), ("quadratic", 0.0))
        given = (number_at(light, "attenuation", term, default=usual) for term, usual in terms)
        attributes["attenuation"] = written(*given)
    if kind == "spot":
        angle = math.degrees(number_at(light, "spot", "outer_angle", default=math.pi / 2.0)) / 2.0
        attributes["cutoff"] = written(min(max(angle, 0.0), 90.0))
    return Element("light", attributes, light.span)


def _colour(element: Element, tag: str, usual: Vector3, strength: float = 1.0) -> str:
    text = text_at(element, tag)
    values = numbers(text, 4) or numbers(text, 3) or usual
    return written(*(min(max(value * strength, 0.0), 1.0) for value in values[:3]))


def ambient_and_background(world: Element) -> tuple[str, str]:
    """Return the colours of the ambient light and of the background in the world's `<scene>`."""
    scene = world.first("scene") or world
    return _colour(scene, "ambient", (0.4, 0.4, 0.4)), _colour(scene, "background", (0.7, 0.7, 0.7))
