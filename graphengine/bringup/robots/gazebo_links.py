"""Converts Gazebo's settings of links and robots: friction, colours, gravity, self-collision and a fixed base."""

from __future__ import annotations

from typing import Any

from graphengine.bringup.robots.gazebo_values import GAZEBO_NAMES, Subject, UnusableError, Values
from graphengine.descriptions.files.xml import Element, numbers
from graphengine.descriptions.robot_files.draft import Draft
from graphengine.descriptions.robot_files.entries import Entry, MaterialKeys, material
from graphengine.devices.rotation import rotate
from graphengine.format.prim_paths import prim_name
from graphengine.format.wording import printable

COLOURS = GAZEBO_NAMES["colours"]
"""A dict from NAME, in lower case, to the diffuse colour (red, green, blue) of a material `Gazebo/NAME` without texture."""
_SURFACE = ("collision", "surface", "friction")
_FRICTION_PATHS: tuple[tuple[str, ...], ...] = ((), (*_SURFACE, "ode"), (*_SURFACE, "bullet"))
"""Paths below which a `<gazebo>` element may have a friction."""
_SOLVER = ("kp", "kd", "minDepth", "min_depth", "maxVel", "max_vel", "maxContacts", "max_contacts")
_Surfaces = dict[str, tuple[Any, ...]]
"""A dict from links to frictions: along, and for a friction with a direction also across, direction and frame."""
_NO_EFFECT = ("preserveFixedJoint", "disableFixedJointLumping", "provideFeedback")
"""Settings of joints without effect, because all fixed joints are kept and the forces of all joints are known."""
_SYSTEMS = ("Sensors", "Imu", "Contact", "Physics", "SceneBroadcaster", "UserCommands")
"""Gazebo Sim systems without effect, because graphengine always provides their functions."""


def add_link_settings(draft: Draft) -> None:
    """Add materials, colours and settings of links, and settings of the whole robot, to the draft."""
    surfaces: _Surfaces = {}
    _static(draft)
    for element in draft.description.element.all("gazebo"):
        name = element.get("reference")
        if name in draft.description.links:
            subject, values = Subject(draft, "link", name, element.span), Values(element)
            for part, tags in _PARTS.items():
                draft.use_parts(element, *tags)
                try:
                    part(subject, values, surfaces)
                except UnusableError as error:
                    subject.lost(error.reason, error.span)
        for child in element.children:
            if child.tag in _NO_EFFECT or (not name and child.tag == "plugin" and _is_always_done(child)):
                draft.use(child)
    _add_materials(draft, surfaces)
    _self_collision(draft)
    _wheel_slip(draft)


def _friction(subject: Subject, values: Values, surfaces: _Surfaces) -> None:
    draft, link = subject.draft, subject.name
    path = next((path for path in _FRICTION_PATHS if values.find(*path, "mu1|mu|mu2") is not None), None)
    if path is None:
        return
    along = values.number(*path, "mu1|mu", default=1.0)
    across = values.number(*path, "mu2", default=along)
    if min(along, across) < 0.0:
        raise UnusableError("the friction is below zero", subject.span)
    if not draft.description.links[link].colliders:
        subject.lost("friction: it has no collider")
        return
    direction = values.find(*path, "fdir1")
    if along == across:
        surfaces.setdefault(link, (along,))
        subject.carried(f"friction {along:g}", {("friction", link): (along, along)})
    elif direction is None:
        surfaces.setdefault(link, (along,))
        draft.second_frictions[link] = across
        reason = "without fdir1, Gazebo takes it along an axis of the world"
        effect = f"mu1 {along:g} holds in all directions, but mu2 across skid-steered wheels"
        subject.lost(f"mu2 {across:g}: {reason}; {effect}")
    else:
        vector, frame = _direction(subject, direction)
        surfaces.setdefault(link, (along, across, vector, frame))
        subject.carried(f"friction {along:g} along fdir1, {across:g} across it", {("friction", link): (along, across)})


def _direction(subject: Subject, element: Element) -> tuple[tuple[float, ...], str]:
    """Return the direction of the friction `mu1` of a link, and the name of the link in whose frame the direction is given.

    The direction on a moving link, such as a wheel, is converted to the frame of the parent link.

    Raises:
        UnusableError: the direction is zero or not numeric, or its frame is not a link.
    """
    text, links = element.text or element.get("value"), subject.draft.description.links
    given = numbers(text, 3)
    if given is None or not any(given):
        raise UnusableError(f"fdir1 {printable(text[:40])!r} is not a direction", element.span)
    vector = (given[0], given[1], given[2])
    frame = next((element.get(key) for key in element.attributes if key.endswith("expressed_in")), "")
    if frame in links:
        return vector, frame
    if frame:
        raise UnusableError(f"fdir1 is expressed in {printable(frame[:60])!r}, which is not a link", element.span)
    carrier = links[subject.name].carrier
    if carrier is None or not carrier.moves:
        return vector, subject.name
    subject.guessed("fdir1 turns with the link in Gazebo; here it stays as at joint position zero")
    return tuple(round(part, 9) for part in rotate(carrier.pose[1], vector)), carrier.parent


def _add_materials(draft: Draft, surfaces: _Surfaces) -> None:
    """Add one material for all links with the same friction.

    As in Gazebo, a contact has the smaller friction of the two colliders.
    """
    alike: dict[tuple[Any, ...], list[str]] = {}
    for link, surface in surfaces.items():
        alike.setdefault(surface, []).append(link)
    for (along, *directed), links in alike.items():
        keys: MaterialKeys = {}
        if directed:
            across, vector, frame = directed
            keys = {"across": across, "direction": list(vector), "expressed_in": frame}
        comment = "as in Gazebo, a contact has the smaller friction of the two colliders"
        draft.materials[f"{prim_name(links[0])[:180]}_surface"] = Entry(material(along, "min", links, keys), [comment])


def _solver(subject: Subject, values: Values, _: _Surfaces) -> None:
    if values.find("|".join(_SOLVER)) is not None:
        text = "kp, kd and other settings of Gazebo's contacts: those of MuJoCo have a time constant, "
        subject.lost(text + "which graphengine chooses")
    if values.find("laserRetro") is not None:
        subject.lost("laserRetro: the intensity of a lidar follows from colours")


def _colour(subject: Subject, values: Values, _: _Surfaces) -> None:
    """Add the colour of a link with visuals that have no material."""
    links, link = subject.draft.description.links, subject.name
    name = values.text("material", "script", "name") or values.text("visual", "material", "script", "name")
    name = name or values.text("material")
    diffuse = values.text("visual", "material", "diffuse") or values.text("material", "diffuse")
    bare = [visual for visual in links[link].element.all("visual") if visual.first("material") is None]
    given = numbers(diffuse, 4) or numbers(diffuse, 3)
    if not (name or diffuse) or not bare:
        return
    known = COLOURS.get(name.rpartition("/")[2].lower().replace("gray", "grey"))
    colour = known if given is None else given[:3]
    if colour is None or not all(0.0 <= part <= 1.0 for part in colour):
        subject.lost(f"material {printable((name or diffuse)[:60])!r} is not a known colour")
        return
    rounded = [round(part, 4) for part in colour]
    subject.draft.links[link].value["colour"] = rounded
    subject.carried("a colour", {("links", link, "colour"): rounded})


def _gravity(subject: Subject, values: Values, _: _Surfaces) -> None:
    if values.flag("gravity") is False or values.flag("turnGravityOff"):
        subject.draft.links[subject.name].value["gravity"] = False
        subject.carried("no gravity", {("links", subject.name, "gravity"): False})


_PARTS = {
    _friction: ("mu1", "mu2", "mu", "fdir1", "collision"),
    _solver: (*_SOLVER, "laserRetro"),
    _colour: ("material", "visual"),
    _gravity: ("gravity", "turnGravityOff"),
}
"""A dict from functions that convert settings of a link to the tags below `<gazebo>` that they read."""


def _static(draft: Draft) -> None:
    """Fix the base to the world if Gazebo's settings make the robot static."""
    for gazebo in draft.description.element.all("gazebo"):
        static = gazebo.first("static") if not gazebo.get("reference") else None
        if static is not None and static.text.strip().lower() in ("true", "1"):
            draft.fixed_base = True
            draft.use(static)
            text = "the base is fixed to the world, because the robot is static"
            draft.carry(text, static.span, {("fixed_base",): True})


def _self_collision(draft: Draft) -> None:
    """Enable self-collision if the robot or all its links with colliders request it; report other requests as lost."""
    asking: list[Subject] = []
    for element in draft.description.element.all("gazebo"):
        name = element.get("reference")
        if name and name not in draft.description.links:
            continue
        draft.use_parts(element, "selfCollide", "self_collide")
        if Values(element).flag("selfCollide|self_collide"):
            asking.append(Subject(draft, "link", name, element.span))
    solid = {name for name, link in draft.description.links.items() if link.colliders}
    names = {subject.name for subject in asking}
    if "" in names or (names and names >= solid):
        draft.settings["self_collision"] = True
        return
    for subject in asking:
        subject.lost("self_collide: self-collision can be enabled only for all links of a robot")


def _wheel_slip(draft: Draft) -> None:
    for element in draft.description.element.all("gazebo"):
        for plugin in element.all("plugin"):
            if "wheelslip" in (plugin.get("name") + plugin.get("filename")).lower().replace("-", "").replace("_", ""):
                draft.use(plugin)
                for wheel in plugin.all("wheel"):
                    text = "WheelSlip: contacts of MuJoCo hold or slide; they do not creep in proportion to the force"
                    Subject(draft, "link", wheel.get("link_name"), plugin.span).lost(text)


def _is_always_done(plugin: Element) -> bool:
    return plugin.get("name").rpartition("::")[2] in _SYSTEMS and "systems" in plugin.get("name")
