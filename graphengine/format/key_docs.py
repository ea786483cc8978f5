"""Descriptions of keys: the docstrings below the fields of a spec class.

This module parses the docstrings when a message or the JSON Schema shows them. Pydantic's `use_attribute_docstrings` would parse
the source of each class at import, and so take a quarter of the import time of the specs.
"""

from __future__ import annotations

import ast
import functools
import inspect
import sys
from collections.abc import Mapping

from pydantic import BaseModel


def key_docs(model: type[BaseModel]) -> Mapping[str, str]:
    """Return the description of each described key: the `description` of the `Field`, or else the docstring."""
    docs: dict[str, str] = {}
    for base in reversed(model.__mro__):
        if issubclass(base, BaseModel) and base is not BaseModel:
            docs = {name: text for name, text in docs.items() if name not in inspect.get_annotations(base)}
            docs |= _docs_in(base.__module__).get(base.__name__, {})
    docs |= {name: field.description for name, field in model.model_fields.items() if field.description}
    return {field.alias or name: docs[name] for name, field in model.model_fields.items() if name in docs}


@functools.cache
def _docs_in(module: str) -> Mapping[str, Mapping[str, str]]:
    """Return the attribute docstrings of each class of a module; empty if the source file is missing or cannot be parsed."""
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
