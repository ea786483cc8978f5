"""The index of the library, by which only the modules that a graph needs are imported.

`python -m tests.nodes.test_index` writes it.
"""

from __future__ import annotations

import importlib
import json
import pkgutil
import subprocess
import sys
from pathlib import Path

from graphengine import nodes
from graphengine.compiler.lint_registry import LINTS
from graphengine.compiler.registry import INDEX, Registry
from tests.cli.harness import ROOT

FILE = Path(nodes.__path__[0]) / INDEX


def index() -> str:
    """What belongs into the index."""
    prefix = f"{nodes.__name__}."
    found: dict[str, list[str]] = {}
    for info in sorted(pkgutil.walk_packages(nodes.__path__, prefix), key=lambda info: info.name):
        registry = Registry()
        module = importlib.import_module(info.name)
        if not info.ispkg:
            registry.add_module(module, "graphengine")
        if registry.owners:
            found[info.name.removeprefix(prefix)] = list(registry.owners)
    return json.dumps(found, indent=1) + "\n"


def test_the_index_names_every_type_of_the_library() -> None:
    assert FILE.read_text("utf-8") == index(), "write it with `python -m tests.nodes.test_index`"


def test_lints_are_in_modules_with_node_types_because_node_types_import_them() -> None:
    listed = json.loads(index())
    modules = {function.__module__.removeprefix(f"{nodes.__name__}.") for found in LINTS.values() for function in found}
    assert modules
    assert modules <= set(listed)


def test_a_check_imports_only_the_modules_of_the_graphs_types_and_no_message_classes() -> None:
    program = """
import contextlib, sys
from graphengine.cli import main
with contextlib.suppress(SystemExit):
    main(["check", "graphs/clock.yaml"])
print(*sys.modules)
"""
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True)
    imported = set(done.stdout.splitlines()[-1].split())
    assert "graphengine.nodes.ros2.state" in imported
    assert not imported & {"graphengine.nodes.ros2.camera", "graphengine.nodes.lidar", "networkx"}
    assert "rosbags.typesys.stores.ros2_jazzy" not in imported


if __name__ == "__main__":
    FILE.write_text(index(), "utf-8")
