"""The pages of file formats: each key with its type, default and meaning, from the pydantic models of the files."""

from __future__ import annotations

import inspect
import json
import re
from collections.abc import Iterator
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt, MaxLen
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from graphengine.cli.node_reference import code, prose, table
from graphengine.format.key_docs import key_docs
from graphengine.format.kinds import DEVICES
from graphengine.format.robot_spec import _TypeOfSensor
from graphengine.format.spec_reader import KINDS
from graphengine.physics.implementations import IMPLEMENTATIONS
from graphengine.physics.model.profiles import SensorProfile
from tests.cli.harness import ROOT

_FILES: dict[str, tuple[str, str, type[BaseModel], str]] = {
    "graph_file.md": (
        "Graph files",
        "A graph file contains nodes and wires. `graphrun schema graph` prints its JSON Schema.",
        KINDS["graph"],
        "graphs/dd100/cmd_vel.yaml",
    ),
    "scene_file.md": (
        "Scene files",
        "A scene file names a world, robots and graphs. `graphrun schema scene` prints its JSON Schema.",
        KINDS["scene"],
        "scenes/dd100_fleet.yaml",
    ),
    "robot_file.md": (
        "Robot files",
        "A robot file names a robot description, such as a URDF, and changes to it. `graphrun import-robot` makes such a file.",
        KINDS["robot"],
        "scenes/robots/dd100.yaml",
    ),
    "sensor_profile.md": (
        "Sensor profiles",
        "A sensor profile has the values of a sensor's data sheet. A robot file names a profile, or lists the values.",
        SensorProfile,
        "scenes/sensors/hc_sr04.yaml",
    ),
}


def pages() -> Iterator[tuple[str, str]]:
    """Yield path and text of each page."""
    for name, (title, about, model, example) in _FILES.items():
        lines = [f"# {title}", "", about, "", f"The last section shows {code(example)}."]
        for inner in _models(model):
            lines += ["", f"## {_name(inner)}", "", prose(_about(inner)), "", *_keys(inner)]
        text = (ROOT / example).read_text(encoding="utf-8")
        lines += [
            "",
            "## Example",
            "",
            f"This is {code(example)}:",
            "",
            "```yaml",
            *text.rstrip("\n").split("\n"),
            "```",
        ]
        yield name, "\n".join([*lines, ""])


def _about(model: type[BaseModel]) -> str:
    return inspect.getdoc(model) or ""  # a model that `create_model` made has the docstring of its base


def _name(model: type[BaseModel]) -> str:
    """Return the heading of a model: the key that it describes, or the name of the class in words."""
    for kind, entry in IMPLEMENTATIONS.all.items():
        if entry.profile is model:
            return kind
    words = re.sub(r"(Spec|Use)$", "", model.__name__)
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", words).lower().capitalize()


def _models(model: type[BaseModel]) -> list[type[BaseModel]]:
    """Return a model and the models of its keys, each once."""
    found = [model]
    for one in found:
        for field in one.model_fields.values():
            found += [inner for inner in _models_in(field.annotation) if inner not in found]
    return found


def _models_in(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for part in get_args(annotation) for model in _models_in(part)]


def _keys(model: type[BaseModel]) -> Iterator[str]:
    docs = {kind: f"Values of {device.title}." for kind, device in DEVICES.all.items()} | dict(key_docs(model))
    rows = []
    for key, field in model.model_fields.items():
        rows.append((code(key), _type_of(key, field), _default(field), prose(docs.get(key, ""))))
    yield from table(("key", "type", "default", "meaning"), rows)


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    if field.default in (None, "", (), {}) or isinstance(field.default, BaseModel):
        return ""
    return code(json.dumps(field.default) if not isinstance(field.default, str) else field.default)


def _type_of(key: str, field: FieldInfo) -> str:
    """Return the type of a key in words, with links to the tables of nested keys."""
    if key == "type" and any(isinstance(one, type) and issubclass(one, _TypeOfSensor) for one in field.metadata):
        return ", ".join(map(code, (*DEVICES.all, "realsense_d455", "rig")))
    bounds = _bounds(field.metadata)
    return _words(field.annotation) + (f", {bounds}" if bounds else "")


_NAMES = {str: "text", int: "whole number", float: "number", bool: "`true` or `false`", NoneType: "", Any: "any value"}


def _words(annotation: Any) -> str:
    origin, parts = get_origin(annotation), get_args(annotation)
    if annotation in _NAMES:
        return _NAMES[annotation]
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return f"[{_name(annotation)}](#{_name(annotation).lower().replace(' ', '-')})"
    if origin is Annotated:
        bounds = _bounds(parts[1:])
        return _words(parts[0]) + (f", {bounds}" if bounds else "")
    if origin is Literal:
        return ", ".join(code(str(part)) for part in parts)
    if origin in (Union, UnionType):
        return " or ".join(word for part in parts if (word := _words(part)))
    if origin is dict:
        return f"mapping of names to {_words(parts[1])}"
    if origin is tuple:
        return f"list of {_words(parts[0])}" if Ellipsis in parts else _fixed([_words(part) for part in parts])
    raise ValueError(f"no words for {annotation!r}")


def _fixed(words: list[str]) -> str:
    """Return the type of a list of fixed length in words."""
    kind, _, bounds = words[0].partition(", each " if words[0].startswith("[") else ", ")
    if bounds and len(set(words)) == 1:
        return f"[{', '.join([kind] * len(words))}], each {bounds}"
    return f"[{', '.join(words)}]"


def _bounds(metadata: Any) -> str:
    """Return the bounds of a value, the lower one first."""
    low, high = list[str](), list[str]()
    for one in metadata:
        if isinstance(one, FieldInfo):
            high += filter(None, [_bounds(one.metadata)])
        low += [f"≥ {one.ge:.10g}"] if isinstance(one, Ge) else [f"> {one.gt:.10g}"] if isinstance(one, Gt) else []
        high += [f"≤ {one.le:.10g}"] if isinstance(one, Le) else [f"< {one.lt:.10g}"] if isinstance(one, Lt) else []
        high += [f"at most {one.max_length} long"] if isinstance(one, MaxLen) else []
    return " and ".join([*low, *high])
