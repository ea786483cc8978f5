"""Adds a material with full grip on any floor for the wheels of a robot."""

from __future__ import annotations

from graphengine.descriptions.robot_files.draft import Draft, Remark
from graphengine.format.wording import printable

NAME = "WheelMaterial"
_FULL = 1.0


def fill(draft: Draft) -> None:
    """Bind the material to each wheel that rolls on the floor, is not a caster's wheel, and has no material yet."""
    bound = draft.bound()
    wheels = [wheel for wheel in draft.wheels.values() if wheel.on_floor and not wheel.swivels and not wheel.drags]
    links = [link for wheel in wheels for link in wheel.rollers.links or (wheel.link,)]
    links = [link for link in dict.fromkeys(links) if link not in bound]
    if not links or NAME in draft.sections["materials"]:
        return
    entry = draft.entry("materials", NAME)
    entry.comments.append("full grip; `max` selects the larger of this friction and the floor's")
    draft.guessed.append(Remark(f"friction of wheels: {_FULL:g} on any floor: {', '.join(map(printable, links))}"))
    entry.value = {"static_friction": _FULL, "dynamic_friction": _FULL, "combine": "max", "bind": links}
