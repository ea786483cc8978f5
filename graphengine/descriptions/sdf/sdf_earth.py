"""Reads the place of an SDF world on Earth."""

from __future__ import annotations

from graphengine.descriptions.earth import EARTH
from graphengine.descriptions.files.xml import Element
from graphengine.descriptions.sdf.sdf_values import SdfError, number_at, text_at
from graphengine.descriptions.worlds.mjcf_elements import written
from graphengine.format.diagnostics import Findings
from graphengine.format.wording import printable

_MOST = {"latitude_deg": 90.0, "longitude_deg": 180.0, "elevation": 1e5, "heading_deg": 360.0}
"""Maximum magnitude of each number, degrees and m."""
_ONLY = {"surface_model": "EARTH_WGS84", "world_frame_orientation": "ENU"}
"""Only legal text of each tag; other surfaces and orientations are not supported."""


def earth_at(world: Element, findings: Findings) -> list[Element]:
    """Return a list of the MJCF `<custom>` element with the place of an SDF world on Earth; empty if the world has no place.

    Raises:
        SdfError: a number is not legal.
    """
    found = world.first("spherical_coordinates")
    if found is None:
        return []
    for tag, legal in _ONLY.items():
        if (text := text_at(found, tag) or legal) != legal:
            what = f"the place of the world is left out: {tag} {printable(text[:60])!r} is not {legal}"
            findings.add("W302", what, (found.first(tag) or found).span)
            return []
    numbers = {key: number_at(found, key, default=0.0) for key in _MOST}
    for key, number in numbers.items():
        if abs(number) > (most := _MOST[key]):
            text = f"{key} must be from -{most:g} to {most:g}, not {number:g}"
            raise SdfError(text, (found.first(key) or found).span)
    numeric = Element("numeric", {"name": EARTH, "data": written(*numbers.values())}, found.span)
    return [Element("custom", {}, found.span, [numeric])]
