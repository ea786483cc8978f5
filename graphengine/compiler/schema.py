"""Makes the JSON Schema of graph, scene and robot files, which editors use for completion and checks.

The schema is derived from the pydantic models of the files and from the registered node classes.
"""

from __future__ import annotations

import inspect
import re
from dataclasses import replace
from typing import Any

from graphengine.compiler.port_texts import brief
from graphengine.compiler.registry import Registry, short_names
from graphengine.format.spec_reader import KINDS
from graphengine.node.node_class import Node
from graphengine.node.port import Port
from graphengine.node.types import PortType

_PARAMETER = {"type": "string", "pattern": r"\$\([A-Za-z_][A-Za-z0-9_]*\)"}
"""JSON Schema of a parameter `$(name)`, which can replace any value in a graph file, including elements of lists."""


def make_schema(kind: str, registry: Registry) -> dict[str, Any]:
    """Return the JSON Schema of one kind of file.

    Args:
        kind: `graph`, `scene` or `robot`.
        registry: node types that the schema of graph files describes; not used for scenes and robots.
    """
    schema = KINDS[kind].model_json_schema()
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    if kind == "graph":
        node = schema["$defs"]["NodeSpec"]
        types = {name: cls for name, cls in registry.types.items() if cls.type_name == name}
        node["properties"]["type"]["examples"] = sorted(types)
        every = {"description": node["properties"]["every"]["description"]}
        node["properties"]["every"] = {"anyOf": [{"$ref": "#/$defs/EverySpec"}, {"const": "once"}, _PARAMETER], **every}
        paces = schema["$defs"]["EverySpec"]["properties"]
        paces |= {name: _or_parameter(paces[name]) for name in ("ticks", "hz")}
        node["allOf"] = [_inputs_of(cls) for _, cls in sorted(types.items())]
        names = sorted({*registry.types, *registry.short_names})
        schema["properties"]["nodes"]["additionalProperties"] = {
            "anyOf": [{"$ref": "#/$defs/NodeSpec"}, {"type": "string", "examples": names}]
        }
    if kind == "robot":  # null removes an entry of the file that `extends` names
        for section in schema["properties"].values():
            if "additionalProperties" in section:
                section["additionalProperties"] = {"anyOf": [section["additionalProperties"], {"type": "null"}]}
    return schema


def _inputs_of(cls: type[Node]) -> dict[str, Any]:
    """Return the JSON Schema of the inputs of a node class; it applies to the nodes whose `type` names the class."""
    names = [cls.type_name, *cls.aliases, *short_names(cls.type_name)]
    ports = [port for port in cls.fields.values() if port.side == "inputs" and not port.is_exec]
    return {
        "if": {"properties": {"type": {"enum": names}}, "required": ["type"]},
        "then": {
            "properties": {
                "inputs": {
                    "description": (inspect.getdoc(cls) or "").partition("\n")[0],
                    "properties": {port.name: _port(port) for port in ports},
                    "patternProperties": {f"^inputs:({'|'.join(re.escape(port.name) for port in ports)})$": {}},
                    "additionalProperties": cls.grows(),
                }
            }
        },
    }


def _port(port: Port) -> dict[str, Any]:
    facts = [f"{port.doc}."] if port.doc else []
    facts += [f"Unit: {port.unit}."] if port.unit else []
    facts += [f"Type: {brief(port.type)}."]
    value = _value(port.type) if isinstance(port.type, PortType) else {}
    bounds = {"minimum": port.ge, "exclusiveMinimum": port.gt, "maximum": port.le, "exclusiveMaximum": port.lt}
    value.get("items", value).update({key: bound for key, bound in bounds.items() if bound is not None})
    if port.tokens:
        value = {"enum": list(port.tokens)}
    return {"description": " ".join(facts), **_or_parameter(value)}


def _or_parameter(value: dict[str, Any]) -> dict[str, Any]:
    takes_text = not value or "string" in value.get("type", ())
    return value if takes_text else {"anyOf": [value, _PARAMETER]}


def _value(port_type: PortType) -> dict[str, Any]:
    if port_type.base == "target":
        return {"type": ["string", "array"], "items": {"type": "string"}}
    if port_type.array:
        return {"type": "array", "items": _or_parameter(_value(replace(port_type, array=False)))}
    if port_type.count > 1:
        element, length = _or_parameter(_value(PortType(port_type.base))), port_type.count
        return {"type": "array", "items": element, "minItems": length, "maxItems": length}
    if port_type.base == "bool":
        return {"type": "boolean"}
    if not port_type.is_number:
        return {"type": "string"} if port_type.base not in ("any", "bundle") else {}
    return {"type": "integer" if port_type.base in ("int", "uint", "int64", "uint64", "uchar") else "number"}
