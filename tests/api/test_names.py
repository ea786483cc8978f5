"""What `import graphengine` offers."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import graphengine as ge
from graphengine.format.errors import GraphError

PACKAGE = Path(ge.__file__).parent


def test_the_package_shows_its_public_names_only() -> None:
    assert sorted(dir(ge)) == sorted(ge.__all__)
    assert set(ge.__all__) >= {"load", "Scene", "Session", "Subscription", "Publication", "Robot", "CheckError"}


def test_every_public_name_is_there_and_documented() -> None:
    for name in ge.__all__:
        assert name == "__version__" or getattr(ge, name).__doc__, name
    assert issubclass(ge.UsageError, GraphError)


def test_a_name_that_is_not_there_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'laod'"):
        getattr(ge, "laod")  # noqa: B009


def test_importing_the_package_imports_neither_numpy_nor_any_room_but_format() -> None:
    program = (
        "import sys, graphengine; print(*sorted(name for name in sys.modules if name.startswith(('graph', 'numpy'))))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.split() == ["graphengine", "graphengine.format", "graphengine.format.version"]


def test_no_module_of_the_package_imports_from_the_package_itself() -> None:
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                assert node.module != "graphengine", path
            if isinstance(node, ast.Import):
                assert all(name.name != "graphengine" for name in node.names), path
