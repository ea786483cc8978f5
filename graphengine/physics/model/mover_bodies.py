"""Adds the bodies and the routes of movers to the world of a scene. The module `movers` reads the routes."""

from __future__ import annotations

import html
from collections.abc import Sequence
from pathlib import Path

from graphengine.descriptions.engine import mujoco
from graphengine.descriptions.files import xml
from graphengine.descriptions.files.references import Library
from graphengine.descriptions.files.xml import Element
from graphengine.descriptions.mjcf.mjcf import is_safe, parse
from graphengine.descriptions.mjcf.mjcf_trial import is_plain
from graphengine.descriptions.routes import PREFIX, Route, route_from, route_of, routes_of
from graphengine.descriptions.sdf.sdf_world import read_world
from graphengine.descriptions.worlds.mjcf_elements import written
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.scene_spec import MoverSpec, SceneSpec
from graphengine.format.spec_reader import Loaded

Part = tuple[str, str, str]
"""A part of a mover: SDF of its shape, centre (m) and colour (red, green, blue; 0 to 1)."""

_BOX = "<box><size>{}</size></box>"
_SKIN, _VEST, _STEEL, _PAINT = "0.85 0.65 0.52", "0.95 0.45 0.1", "0.25 0.25 0.28", "0.95 0.7 0.1"
_PERSON: list[Part] = [
    ("<capsule><radius>0.18</radius><length>1.08</length></capsule>", "0 0 0.72", _VEST),
    ("<ellipsoid><radii>0.1 0.077 0.17</radii></ellipsoid>", "0 0 1.586", _SKIN),
]
"""A person who looks along x. The measures are the means of men in ANSUR II (Gordon et al.: 2012 Anthropometric Survey of U.S.
Army Personnel, NATICK/TR-15/007): stature 1.756 m, shoulder height 1.44 m, head 0.2 m long and 0.154 m wide. The capsule has
the cross-section of an ellipse 0.51 m wide and 0.254 m deep: the breadth of the shoulders, and the depth of the chest."""
_FORKLIFT: list[Part] = [
    (_BOX.format("1.6 1.15 0.8"), "-0.5 0 0.5", _PAINT),
    (_BOX.format("1 1.05 0.05"), "-0.5 0 2.1", _STEEL),
    *((_BOX.format("0.06 0.06 1.2"), f"{x} {y} 1.5", _STEEL) for x in (-0.95, -0.05) for y in (-0.45, 0.45)),
    *((_BOX.format("0.12 0.1 2"), f"0.4 {y} 1.05", _STEEL) for y in (-0.3, 0.3)),
    *((_BOX.format("1.1 0.12 0.05"), f"1 {y} 0.1", _STEEL) for y in (-0.25, 0.25)),
]
"""A counterbalanced forklift for 2.5 t with typical measures: 1.15 m wide, 2.1 m high, forks of 1.1 m."""
_SHAPES = {"person": _PERSON, "forklift": _FORKLIFT}
_COLLISION = """<collision name="{}">
  <geometry>{}</geometry><pose>{} 0 0 0</pose><material><diffuse>{} 1</diffuse></material>
</collision>"""


def add_movers(spec: mujoco.MjSpec, scene: Loaded[SceneSpec], library: Library, findings: Findings) -> None:
    """Add the movers of a scene and the actors of its SDF world to the world; errors are added to `findings`.

    Args:
        spec: the world; it has the routes of actors.
        scene: scene file with the movers.
        library: reads mesh files.
        findings: receives errors.
    """
    document, routes = scene.document, {name: route_from(text) for name, text in routes_of(spec).items()}
    models = [_model(name, route, _PERSON, document.key_span("world")) for name, route in routes.items()]
    for name, mover in scene.spec.movers.items():
        span = document.key_span("movers", name)
        if name in routes or spec.body(name) is not None:
            findings.add("S105", f"the world already has a body named {name!r}", span, "choose another name")
            continue
        place = document.span("movers", name, "shape")
        if (parts := _parts(mover, scene, library, findings, place)) is not None:
            routes[name] = route_of(mover)
            models.append(_model(name, routes[name], parts, place))
            spec.add_text(name=f"{PREFIX}{name}", data=routes[name].text())
    taken = [name for name in routes if spec.body(name) is not None]
    for name in taken:
        findings.add("S105", f"an actor has the name of the body {name!r} of the world", document.key_span("world"))
    if models and not taken:
        world = Element("world", {"name": "movers"}, document.key_span("movers"), models)
        _attach(spec, Element("sdf", {"version": "1.9"}, world.span, [world]), document.path, library)


def _parts(
    mover: MoverSpec, scene: Loaded[SceneSpec], library: Library, findings: Findings, span: Span
) -> Sequence[Part] | None:
    """Return the parts of a mover. If its mesh file is not found, add an error to `findings` and return None."""
    if mover.size is not None:
        return [(_BOX.format(written(*mover.size)), written(0.0, 0.0, mover.size[2] / 2.0), _PAINT)]
    if mover.shape in _SHAPES:
        return _SHAPES[mover.shape]
    path = library.files.look_up(mover.shape, scene.folder, findings, span)
    return [(f"<mesh><uri>{html.escape(str(path))}</uri></mesh>", "0 0 0", _PAINT)] if path is not None else None


def _model(name: str, route: Route, parts: Sequence[Part], span: Span) -> Element:
    """Return the SDF model of a mover, at the start of its route; `span` is the position of its key `shape` in the file."""
    shapes = "".join(_COLLISION.format(number, *part) for number, part in enumerate(parts))
    place = written(*route.points[0][1:])
    text = f"<model><static>true</static><pose>{place} 0 0 0</pose><link>{shapes}</link></model>"
    model = xml.parse(text.encode(), name, Findings(), "S102")
    assert model is not None
    for element in model.walk():
        element.span = span
    model.attributes["name"] = model.children[-1].attributes["name"] = name
    return model


def _attach(spec: mujoco.MjSpec, sdf: Element, path: Path, library: Library) -> None:
    """Convert an SDF world with the models of movers, and add its bodies to the world of a scene."""
    before = library.memory
    made = read_world(path, sdf, library, library.findings)
    if made is None or not library.weigh(made):
        return
    library.memory += before
    if not (is_plain(made, 0.0) or is_safe(made, library, "world")):
        return
    movers, _ = parse(made, library)
    if movers is not None:
        for texture in list(movers.textures):  # the sky
            movers.delete(texture)
        movers.assets.clear()
        movers.option = spec.option
        for body in movers.worldbody.bodies:
            body.sleep = mujoco.mjtSleepPolicy.mjSLEEP_NEVER
            # Its turns do not change the velocity of a body whose centre of mass is its origin, not even by rounding.
            body.explicitinertial, body.mass, body.inertia = True, 1.0, [1.0, 1.0, 1.0]
            body.ipos, body.iquat = [0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]
        spec.attach(movers, frame=spec.worldbody.add_frame(), prefix="")
        spec.assets = library.assets
