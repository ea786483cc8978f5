"""Starting is quick because nothing heavy is imported before something needs it."""

from __future__ import annotations

import ast
import re
import subprocess
import sys

import pytest

from graphengine.cli import VERBS
from tests.cli.harness import ROOT, Graphrun, environment

HEAVY = [
    "collada",
    "cyclonedds",
    "mcap",
    "mujoco",
    "networkx",
    "numpy",
    "pydantic",
    "rich",
    "rosbags",
    "shtab",
    "trimesh",
    "xacro",
    "yaml",
]

SCRIPT = """
import contextlib, io, sys
from graphengine.cli import main
with contextlib.redirect_stdout(io.StringIO()) as said, contextlib.suppress(SystemExit):
    main(sys.argv[1:])
assert said.getvalue()
print(sorted({name.partition(".")[0] for name in sys.modules}))
"""


def imported(*arguments: str) -> set[str]:
    """Packages that a command imports."""
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, *arguments],
        cwd=ROOT,
        env=environment(),
        capture_output=True,
        text=True,
        check=True,
    )
    found: set[str] = set(ast.literal_eval(done.stdout))
    assert "graphengine" in found
    return found


@pytest.mark.parametrize(
    "arguments", [("--help",), ("--version",), *((verb, "--help") for verb in VERBS)], ids=" ".join
)
def test_help_and_version_import_nothing_heavy(arguments: tuple[str, ...]) -> None:
    assert imported(*arguments).isdisjoint(HEAVY)


def test_node_types_need_arrays_and_messages_but_neither_files_nor_planning_nor_physics() -> None:
    assert imported("nodes") & set(HEAVY) == {"numpy", "rosbags"}


@pytest.mark.parametrize("verb", VERBS)
def test_each_verb_has_help(graphrun: Graphrun, verb: str) -> None:
    result = graphrun(verb, "--help", code=0, err="")
    assert result.out.startswith(f"usage: graphrun {verb} ")


def test_the_help_names_every_verb(graphrun: Graphrun) -> None:
    result = graphrun("--help", code=0)
    assert [verb for verb in VERBS if re.search(rf"^    {verb}\s", result.out, re.MULTILINE)] == list(VERBS)


def test_the_version_is_that_of_the_package(graphrun: Graphrun) -> None:
    from graphengine import __version__

    assert graphrun("--version").out == f"graphrun {__version__}\n"


def test_the_verbose_version_lists_transports_with_remedies(
    graphrun: Graphrun, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "cyclonedds", None)
    said = graphrun("--version", "--verbose", code=0).out
    assert "\ntransport memory: can be used\n" in said
    assert "\ntransport dds: import of cyclonedds halted" in said
    assert (
        "\n  use one of these, or a sourced ROS 2 with --transport rclpy, or no network with --transport memory\n"
        in said
    )
