"""Descriptions of keys: the docstrings below the fields of a spec class.

They are parsed when a message or the JSON Schema shows them, because pydantic's `use_attribute_docstrings` parses the source of
each class at import, which takes a quarter of the time that importing the specs does.
"""

from __future__ import annotations

import ast
import functools
import inspect
import sys
from collections.abc import Mapping

from pydantic import BaseModel


def key_docs(model: type[BaseModel]) -> Mapping[str, str]:
    """Return the description of each key that has one: the `description` of its `Field`, or else its docstring."""
    docs: dict[str, str] = {}
    for base in reversed(model.__mro__):
        if issubclass(base, BaseModel) and base is not BaseModel:
            docs = {name: text for name, text in docs.items() if name not in inspect.get_annotations(base)}
            docs |= _docs_in(base.__module__).get(base.__name__, {})
    docs |= {name: field.description for name, field in model.model_fields.items() if field.description}
    return {field.alias or name: docs[name] for name, field in model.model_fields.items() if name in docs}


@functools.cache
def _docs_in(module: str) -> Mapping[str, Mapping[str, str]]:
    """Return the attribute docstrings of each class of a module; empty if its source file is missing or no longer parses."""
    try:
        tree = ast.parse(inspect.getsource(sys.modules[module]))
    except (KeyError, OSError, SyntaxError, TypeError, ValueError):
        return {}
    return {node.name: _docs_of(node) for node in tree.body if isinstance(node, ast.ClassDef)}


def _docs_of(definition: ast.ClassDef) -> Mapping[str, str]:
    docs = {}
    for field, below in zip(definition.body, definition.body[1:], strict=False):
        match field, below:
            case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(value=ast.Constant(value=str(text))):
                docs[name] = inspect.cleandoc(text)
    return docs
