"""The exceptions are what their module draws."""

from __future__ import annotations

import importlib
import pkgutil
import re

import pytest

import graphengine
from graphengine.format import errors
from graphengine.format.errors import GraphError

_LINE = re.compile(r"^(?P<lead>[│├└─ ]*)(?P<name>\w+) ", re.MULTILINE)


def drawn() -> dict[str, str]:
    """Name of each exception below the root, and that of the one it is drawn below."""
    parents: dict[str, str] = {}
    above: dict[int, str] = {}
    for line in _LINE.finditer(str(errors.__doc__).split("\n\n", 1)[1]):
        depth = len(line["lead"]) // 4
        above[depth] = line["name"]
        if depth:
            parents[line["name"]] = above[depth - 1]
    return parents


def raised(parent: type[Exception]) -> dict[str, str]:
    """The same of the classes themselves."""
    own = [cls for cls in parent.__subclasses__() if cls.__module__.split(".")[0] == "graphengine"]
    return {cls.__name__: parent.__name__ for cls in own} | {k: v for cls in own for k, v in raised(cls).items()}


def test_the_drawn_tree_of_exceptions_equals_the_classes() -> None:
    pytest.importorskip("cyclonedds", reason="the test imports all modules of the package")
    for module in pkgutil.walk_packages(graphengine.__path__, "graphengine."):
        if not module.name.endswith("__main__") and not module.name.startswith("graphengine._data"):
            importlib.import_module(module.name)
    assert drawn() == raised(GraphError)
