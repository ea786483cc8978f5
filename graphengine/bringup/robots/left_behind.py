"""Lists the elements of a description that no module of the import has used."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from graphengine.descriptions.files.xml import Element, number
from graphengine.descriptions.robot_description import Joint
from graphengine.descriptions.robot_files.draft import Draft
from graphengine.format.wording import printable
from graphengine.format.yaml_text import scalar


def report_unused(draft: Draft) -> None:
    """Add a remark to `draft.lost` for each type of unused elements."""
    root = draft.description.element
    unused = [element for element in root.children if not draft.used(element)]
    for tag in ("transmission", "ros2_control"):
        if found := [element for element in unused if element.tag == tag]:
            names = _names([each.get("name") for each in found])
            draft.lose(f"{tag} {names}: it lists no moving joint", found[0].span)
    _gazebo(draft, [element for element in unused if element.tag == "gazebo"])
    parts = _unused_parts(draft, draft.description.joints.values())
    for tag in ("safety_controller", "calibration"):
        if found := [part for part in parts if part.tag == tag]:
            draft.lose(f"{tag} of joints", found[0].span)
    if textures := [element for element in root.walk() if element.tag == "texture"]:
        draft.lose("textures of materials", textures[0].span)
    moving = _unused_parts(draft, draft.description.moving())
    if fast := [part for part in moving if part.tag == "limit" and (number(part.get("velocity")) or 0.0) > 0]:
        draft.lose("velocity limits of joints without a drive, which have no set point to limit", fast[0].span)


def _unused_parts(draft: Draft, joints: Iterable[Joint]) -> list[Element]:
    """Return the unused elements directly below the elements of joints."""
    return [part for joint in joints for part in joint.element.children if not draft.used(part)]


def _gazebo(draft: Draft, elements: Sequence[Element]) -> None:
    """Add remarks on unused `<gazebo>` elements, one remark for equal elements of several links or joints."""
    alike: dict[str, list[Element]] = {}
    for gazebo in elements:
        left = [child for child in gazebo.children if not draft.used(child)]
        if left or not gazebo.children:
            alike.setdefault(", ".join(map(_described, left)) or "nothing", []).append(gazebo)
    for what, found in alike.items():
        owners = _names([name for element in found if (name := element.get("reference"))])
        draft.lose(f"gazebo {what}: {owners}" if owners else f"gazebo {what}", found[0].span)


def _described(element: Element) -> str:
    """Return the tag, name, type and text of an element as one text; empty values are left out."""
    words = (element.tag, element.get("name"), element.get("type"), element.text[:60])
    return printable(" ".join(word for word in words if word))


def _names(names: Sequence[str]) -> str:
    return ", ".join(printable(scalar(name)) for name in names)
