"""The material of wheels: full grip on any floor."""

from __future__ import annotations

from graphengine.physics.importing.draft import Draft

NAME = "WheelMaterial"


def fill(draft: Draft) -> None:
    """Bind the wheels that stand on the floor and have no material yet."""
    bound = draft.bound()
    links = [wheel.link for wheel in draft.wheels.values() if wheel.on_floor and not wheel.swivels]
    links = [link for link in dict.fromkeys(links) if link not in bound]
    if not links or NAME in draft.sections["materials"]:
        return
    entry = draft.entry("materials", NAME)
    entry.comments.append("full grip, whatever the friction of the floor: `max` overrules it")
    entry.value = {"static_friction": 1.0, "dynamic_friction": 1.0, "combine": "max", "bind": links}
