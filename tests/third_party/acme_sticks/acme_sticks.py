"""Reads stick figures: a line `stick NAME on PARENT length L mass M [hinge x|y|z]` adds a link at the end of its parent."""

from __future__ import annotations

from graphengine.descriptions.files.xml import Element
from graphengine.format.diagnostics import Findings, Source, Span


def read(source: Source, findings: Findings) -> Element | None:
    """Return the stick figure as URDF."""
    root = Element("robot", {"name": "sticks"}, Span(source, 1, 1))
    lengths: dict[str, str] = {}
    for number, line in enumerate(source.lines, 1):
        span, words = Span(source, number, 1, max(len(line), 1)), line.split()
        if not words or words[0].startswith("#"):
            continue
        facts = dict(zip(words[0::2], words[1::2], strict=False))
        if "stick" not in facts or "length" not in facts or "mass" not in facts:
            findings.add("S103", "a line needs: stick NAME length L mass M", span)
            continue
        name, parent, length = facts["stick"], facts.get("on", ""), facts["length"]
        link = Element("link", {"name": name}, span)
        middle = Element("origin", {"xyz": f"0 0 {float(length) / 2}"}, span)
        mass = Element("mass", {"value": facts["mass"]}, span)
        inertia = Element("inertia", dict.fromkeys(("ixx", "iyy", "izz"), "0.01"), span)
        box = Element("geometry", {}, span, [Element("cylinder", {"radius": "0.02", "length": length}, span)])
        link.children = [Element("inertial", {}, span, [middle, mass, inertia])]
        link.children += [Element(tag, {}, span, [middle, box]) for tag in ("visual", "collision")]
        root.children.append(link)
        if parent:
            axis = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}.get(facts.get("hinge", ""), "")
            joint = Element("joint", {"name": f"{name}_joint", "type": "continuous" if axis else "fixed"}, span)
            joint.children = [Element("parent", {"link": parent}, span), Element("child", {"link": name}, span)]
            joint.children.append(Element("origin", {"xyz": f"0 0 {lengths.get(parent, '0')}"}, span))
            joint.children += [Element("axis", {"xyz": axis}, span)] if axis else []
            root.children.append(joint)
        lengths[name] = length
    return root
