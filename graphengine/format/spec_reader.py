"""Reads graph, scene and robot files as specs; each error becomes a finding with its position in the file."""

from __future__ import annotations

import json
import re
import types
import typing
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from graphengine.format import document as documents
from graphengine.format.diagnostics import MAX_ERRORS, Findings
from graphengine.format.document import Document, Location
from graphengine.format.errors import UsageError
from graphengine.format.given_text import GivenText
from graphengine.format.key_docs import key_docs
from graphengine.format.regular_files import StrPath
from graphengine.format.robot_spec import RobotSpec
from graphengine.format.scene_spec import SceneSpec
from graphengine.format.spec import FORMAT, GraphSpec, NodeSpec, Spec
from graphengine.format.wording import listing, shown

S = TypeVar("S", bound=Spec)

KINDS: dict[str, type[Spec]] = {"graph": GraphSpec, "scene": SceneSpec, "robot": RobotSpec}
"""Spec class of each kind of file; each file has a key with the name of its kind, such as `graph: drive`."""

SCENARIO = "scenario"
"""Key with which `graphengine.experiments` recognizes scenario files."""

_PLAIN: Mapping[str, tuple[str, str]] = {
    "missing": ("G107", "missing key {name!r}"),
    "extra_forbidden": ("G106", "unknown key {name!r}"),
    "literal_error": ("G109", "{name}: expected {expected}, got {input}"),
    "greater_than": ("G109", "{name}: expected a value > {gt:g}, got {input}"),
    "greater_than_equal": ("G109", "{name}: expected a value ≥ {ge:g}, got {input}"),
    "less_than": ("G109", "{name}: expected a value < {lt:g}, got {input}"),
    "less_than_equal": ("G109", "{name}: expected a value ≤ {le:g}, got {input}"),
    "string_pattern_mismatch": (
        "G109",
        "{input} is not a valid name: use letters, digits and '_', but no leading digit",
    ),
    "string_type": ("G108", "{name}: expected text, got {input}"),
    "string_too_short": ("G109", "{name}: expected text, got {input}"),
    "string_too_long": ("G109", "{name}: expected at most {max_length} characters"),
    "float_type": ("G108", "{name}: expected a number, got {input}"),
    "int_type": ("G108", "{name}: expected a whole number, got {input}"),
    "bool_type": ("G108", "{name}: expected true or false, got {input}"),
    "dict_type": ("G108", "{name}: expected a mapping, got {input}"),
    "model_type": ("G108", "{name}: expected a mapping, got {input}"),
    "model_attributes_type": ("G108", "{name}: expected a mapping, got {input}"),
    "tuple_type": ("G108", "{name}: expected a list, got {input}"),
    "too_long": ("G108", "{name}: expected {max_length} values, got {actual_length}"),
    "finite_number": ("G109", "{name}: expected a finite number, got {input}"),
    "value_error": ("G109", "{name}: {msg}"),
}


def validate(model: type[S], document: Document, data: Any, findings: Findings) -> S | None:
    """Validate plain data as a spec; add errors with their positions to `findings`, and then return None.

    Args:
        model: class of the spec.
        document: file that contains the data, for positions.
        data: data to validate; values of parameters may replace values of the file.
        findings: receives the errors.
    """
    if isinstance(data, dict) and type(data.get("format")) is int and data["format"] != FORMAT:
        message = f"format {data['format']} is not supported"
        remedy = f"this version reads format {FORMAT}; a file with a higher number needs a newer graphengine"
        findings.add("G110", message, document.span("format"), remedy)
        return None
    if isinstance(data, dict) and _is_of_another_kind(model, document, data, findings):
        return None
    try:
        return model.model_validate(data)
    except ValidationError as errors:
        for error in errors.errors(include_url=False)[:MAX_ERRORS]:
            _report(model, document, typing.cast("dict[str, Any]", error), findings)
        return None


def read_given(model: type[S], name: str, given: Mapping[str, Any]) -> S:
    """Validate keys and values that a program or user gave, such as the arguments of a command.

    Args:
        model: class of the spec.
        name: name for messages.
        given: JSON types by key.

    Raises:
        UsageError: the keys or values are invalid.
    """
    findings = Findings()
    document = documents.parse(json.dumps(given, default=str), name, findings)
    spec = validate(model, document, given, findings) if document is not None else None
    if spec is None:
        wrong = findings.errors[0]
        raise UsageError("\n  ".join([f"{name}: {wrong.message.removeprefix('file: ')}", *wrong.help]))
    return spec


def _is_of_another_kind(model: type[Spec], document: Document, data: Any, findings: Findings) -> bool:
    """Return whether a file is of another kind than `model`, such as a scene instead of a graph, and add one finding if so."""
    if SCENARIO in data and SCENARIO not in model.model_fields:
        remedy = "run it with `graphrun test`; `graphrun test --collect-only` only checks it"
        findings.add("G107", "this is a scenario, not a scene, robot or graph", document.key_span(SCENARIO), remedy)
        return True
    wanted = next((kind for kind, known in KINDS.items() if known is model), None)
    other = kind_of(document)
    if wanted is None or other is None or wanted in data or other in model.model_fields:
        return False
    findings.add("G107", f"missing key {wanted!r}: this is a {other} file", document.key_span(other))
    return True


def _report(model: type[Spec], document: Document, error: dict[str, Any], findings: Findings) -> None:
    location, kind = tuple(error["loc"]), error["type"]
    is_key = bool(location) and location[-1] == "[key]"
    location = location[:-1] if is_key else location
    name = _name(location)
    code, template = _PLAIN.get(kind, ("G108", "{name}: {msg}"))
    message = template.format(
        name=name,
        input=shown(error["input"]),
        msg=error["msg"].removeprefix("Value error, "),
        **{key: value for key, value in error.get("ctx", {}).items() if key != "error"},
    )
    if kind == "extra_forbidden":
        models = _models_at(model, location[:-1])
        legal = [key for found in models for key in keys_of(found)]
        hint = "set port values under `inputs:`" if NodeSpec in models else ""
        near = findings.guess(name, legal)
        advice = (near,) if near else (listing(legal, "keys"), hint)
        findings.add(code, message, document.key_span(*location), *advice)
    elif kind == "missing" and isinstance(location[-1], int):
        at = location[:-1]
        wanted = [len(typing.get_args(found)) for found in _annotations_at(model, at)]
        given = document.find(*at)
        got = len(given.data) if given is not None and isinstance(given.data, list) else "fewer"
        findings.add("G108", f"{_name(at)}: expected {max(wanted, default=0)} values, got {got}", document.span(*at))
    elif kind == "missing":
        parent = location[:-1]
        span = document.key_span(*parent) if parent else document.span().part(0, 1)
        meaning = _description(model, location)
        findings.add(code, message, span, f"meaning: {meaning}" if meaning else "")
    elif is_key:
        legal_name = re.sub(r"\A(?=[0-9])", "_", re.sub(r"[^A-Za-z0-9_]", "_", str(error["input"])))
        fits = kind == "string_pattern_mismatch" and legal_name
        findings.add(code, message, document.key_span(*location), f"write {legal_name}" if fits else "")
    elif kind == "value_error":
        value = document.find(*location)
        whole = value is not None and isinstance(value.data, dict)
        findings.add(code, message, document.key_span(*location) if whole else document.span(*location))
    else:
        legal = [key for found in _models_at(model, location) for key in keys_of(found)]
        empty = "write the value of the key, or remove the key" if error["input"] is None else ""
        meaning = _description(model, location) or (listing(legal, "keys") if legal else "")
        findings.add(code, message, document.span(*location), meaning, empty)


def keys_of(model: type[BaseModel]) -> Mapping[str, FieldInfo]:
    """Return each field of a spec by its key in a file, such as `for` for a field `for_`."""
    return {field.alias or name: field for name, field in model.model_fields.items()}


def _name(location: Location) -> str:
    """Return the name of a location for messages: the last key with indices, such as `position[1]`, or `file` without a key."""
    names = [index for index, part in enumerate(location) if isinstance(part, str)]
    numbers = location[names[-1] + 1 :] if names else location
    return (str(location[names[-1]]) if names else "file") + "".join(f"[{number}]" for number in numbers)


def _annotations_at(annotation: Any, location: Location) -> list[Any]:
    """Return the types that the value at a location may have: spec classes, tuple types or scalar types.

    Args:
        annotation: spec class or type annotation at which the location starts.
        location: keys and indices that lead to the value.
    """
    origin, arguments = typing.get_origin(annotation), typing.get_args(annotation)
    if origin is Annotated:
        return _annotations_at(arguments[0], location)
    if origin in (typing.Union, types.UnionType):
        return [found for argument in arguments for found in _annotations_at(argument, location)]
    if not location:
        return [annotation]
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        known = keys_of(annotation).get(str(location[0]))
        return _annotations_at(known.annotation, location[1:]) if known else []
    if origin in (dict, tuple):
        return _annotations_at(arguments[1] if origin is dict else arguments[0], location[1:])
    return []


def _models_at(model: type[Spec], location: Location) -> list[type[BaseModel]]:
    found = _annotations_at(model, location)
    return [one for one in found if isinstance(one, type) and issubclass(one, BaseModel)]


def _description(model: type[Spec], location: Location) -> str:
    """Return the description of the key at a location in the spec; empty for the whole file or an undescribed key."""
    if not location:
        return ""
    described = (key_docs(found).get(str(location[-1])) for found in _models_at(model, location[:-1]))
    return next(filter(None, described), "")


@dataclass(frozen=True, slots=True, eq=False)
class Loaded(typing.Generic[S]):
    """A spec, and the document from which the spec was read; the document has the positions for later findings."""

    spec: S
    document: Document

    @property
    def folder(self) -> Path:
        """Folder of the file, where relative paths in the file start."""
        return self.document.path.parent


def read(
    model: type[S], path: StrPath, findings: Findings, shown_as: str | None = None, *, given: GivenText | None = None
) -> Loaded[S] | None:
    """Read a file and validate it as a spec; add errors to `findings`, and then return None.

    The arguments are those of `document.load`.
    """
    document = documents.load(path, findings, shown_as, given=given)
    if document is None:
        return None
    spec = validate(model, document, document.data, findings)
    return Loaded(spec, document) if spec is not None else None


def kind_of(document: Document) -> str | None:
    """Return the first of `graph`, `scene` and `robot` that is a key of the file; None without such a key or for a scenario."""
    if not isinstance(document.data, dict) or SCENARIO in document.data:
        return None
    return next((kind for kind in KINDS if kind in document.data), None)
