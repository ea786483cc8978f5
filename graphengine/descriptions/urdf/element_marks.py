"""Writes the source locations of a description into its MjSpec, from which MuJoCo's errors repeat them, and finds them there."""

from __future__ import annotations

from collections.abc import Iterable

from graphengine.descriptions.engine import all_bodies, mujoco
from graphengine.descriptions.files.xml import Element


def mark(spec: mujoco.MjSpec, element: Element) -> None:
    """Set `info` of bodies, joints, geoms and meshes to the location (file:line:column) of their elements.

    Args:
        spec: specification that MuJoCo made from `element`.
        element: description from `for_mujoco`, in which all links, joints, colliders and visuals have names.
    """
    named = {part.get("name"): part for part in element.walk() if part.tag in ("link", "joint", "collision", "visual")}
    meshes = {mesh.name: mesh for mesh in spec.meshes}
    for body in all_bodies(spec):
        for each in (body, *body.joints, *body.geoms):
            if (part := named.get(each.name)) is not None:
                each.info = str(part.span)
        for geom in body.geoms:
            if geom.name in named and geom.meshname in meshes:
                shape = next(shape for shape in named[geom.name].walk() if shape.tag == "mesh")
                meshes[geom.meshname].info = str(shape.span)


def marked(error: Exception, roots: Iterable[Element]) -> Element | None:
    """Return the element of a description whose location an error of MuJoCo repeats; None without a location."""
    elements = (element for root in roots for element in root.walk())
    return next((element for element in elements if str(error).endswith(f", {element.span}")), None)


def called(element: Element) -> str:
    """Return the name by which users know an element: the file of a mesh, else the name."""
    return element.get("filename") or element.get("name")
