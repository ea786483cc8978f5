"""Reads the place of an SDF world on Earth."""

from __future__ import annotations

from pydantic import ValidationError

from graphengine.descriptions.earth import EARTH, numbers_of
from graphengine.descriptions.files.xml import Element
from graphengine.descriptions.sdf.sdf_values import SdfError, number_at, text_at, written
from graphengine.format.spec import EarthSpec
from graphengine.format.wording import printable

_KEYS = ("latitude_deg", "longitude_deg", "elevation", "heading_deg")
_ONLY = {"surface_model": "EARTH_WGS84", "world_frame_orientation": "ENU"}
"""Text that a tag must have; Gazebo too has no other orientation."""


def earth_at(world: Element) -> list[Element]:
    """Return the MJCF `<custom>` element with the place of an SDF world; an empty list if the world has no place.

    Raises:
        SdfError: the place is not on Earth.
    """
    found = world.first("spherical_coordinates")
    if found is None:
        return []
    for tag, legal in _ONLY.items():
        if (text := text_at(found, tag) or legal) != legal:
            raise SdfError(f"{tag} must be {legal}, not {printable(text[:60])!r}", (found.first(tag) or found).span)
    try:
        earth = EarthSpec.model_validate({key: number_at(found, key, default=0.0) for key in _KEYS})
    except ValidationError as errors:
        first = errors.errors(include_url=False)[0]
        key = str(first["loc"][0])
        raise SdfError(f"{key} {first['input']:g}: {first['msg']}", (found.first(key) or found).span) from errors
    numeric = Element("numeric", {"name": EARTH, "data": written(*numbers_of(earth))}, found.span)
    return [Element("custom", {}, found.span, [numeric])]
