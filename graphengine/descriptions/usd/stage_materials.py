"""Reads physics materials and colours; runs in the confined process."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from pxr import Usd, UsdPhysics, UsdShade

from graphengine.descriptions.usd.stage_frames import given, number, text
from graphengine.descriptions.usd_model import StageMaterial

Colour = tuple[float, float, float, float]
_RULES = ("average", "min", "multiply", "max")
_COLOURS = ("diffuseColor", "diffuse_color_constant", "diffuse_tint", "base_color", "diffuse_reflection_color")
"""Inputs of surface shaders that have the colour: those of UsdPreviewSurface, then those of Isaac Sim's MDL materials."""


def physics_material(prim: Usd.Prim) -> tuple[str, float]:
    """Return the path of a collider's physics material and its density in the units of the stage; empty and 0 without one."""
    bound = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial("physics")[0]
    if not bound or not bound.GetPrim().HasAPI(UsdPhysics.MaterialAPI):
        return "", 0.0
    return str(bound.GetPath()), max(number(bound.GetPrim(), "physics:density"), 0.0)


def read_material(prim: Usd.Prim) -> StageMaterial:
    """Return a physics material; what it leaves out is 0, as in UsdPhysics."""
    static, dynamic, bounce = (
        max(number(prim, f"physics:{name}"), 0.0) for name in ("staticFriction", "dynamicFriction", "restitution")
    )
    rule = text(prim, "physxMaterial:frictionCombineMode")
    return StageMaterial(_bounded(static), _bounded(dynamic), min(bounce, 1.0), rule if rule in _RULES else "average")


def colour_of(prim: Usd.Prim) -> Colour | None:
    """Return the colour of a prim: that of its material's surface, else its display colour; None without one."""
    material = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
    shader = _surface(material) if material else None
    if shader is not None:
        for name in _COLOURS:
            if (value := _constant(shader, name)) is not None and (found := _colour(value, _opacity(shader))):
                return found
    display = given(prim, "primvars:displayColor")
    return _colour(display[0], 1.0) if display is not None and len(display) else None


def has_texture(prim: Usd.Prim) -> bool:
    """Return whether the colour of a prim's material comes from a picture."""
    material = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
    shader = _surface(material) if material else None
    source = shader.GetInput("diffuseColor") if shader is not None else None
    return bool(source and source.HasConnectedSource()) or bool(shader and shader.GetInput("diffuse_texture"))


def _surface(material: UsdShade.Material) -> UsdShade.Shader | None:
    sources = (material.ComputeSurfaceSource(context)[0] for context in ("", "mdl"))
    return next((source for source in sources if source), None)


def _constant(shader: UsdShade.Shader, name: str) -> Any:
    source = shader.GetInput(name)
    if not source:
        return None
    attributes = source.GetValueProducingAttributes()
    value: Any = (
        attributes[0].Get() if attributes and UsdShade.Utils.GetType(attributes[0].GetName()) != _OUTPUT else None
    )
    return value if hasattr(value, "__len__") and len(value) >= 3 else None


_OUTPUT = UsdShade.AttributeType.Output


def _opacity(shader: UsdShade.Shader) -> float:
    source = shader.GetInput("opacity")
    value = source.Get() if source else None
    return float(value) if isinstance(value, int | float) else 1.0


def _colour(value: Any, opacity: float) -> Colour | None:
    parts = np.array([*value[:3], opacity], np.float64)
    if not np.isfinite(parts).all():
        return None
    red, green, blue, alpha = np.clip(parts, 0.0, 1.0).tolist()
    return red, green, blue, alpha


def _bounded(friction: float) -> float:
    return friction if math.isfinite(friction) else 0.0
