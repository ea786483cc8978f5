"""`graphrun demo`: it runs the scene, says what to try, and ends well."""

from __future__ import annotations

import re
import shlex
import signal
from pathlib import Path

import pytest

from graphengine.cli import make_parser
from graphengine.cli.demo import INTRODUCTION
from tests.cli.harness import ROOT, Graphrun, live, process

MEMORY = ("--no-view", "--transport", "memory")
TRIED = [shlex.split(line)[1:] for line in INTRODUCTION.splitlines() if line.startswith("  graphrun ")]


def test_the_demo_prints_commands_to_try_and_runs_the_scene(graphrun: Graphrun) -> None:
    said = graphrun("demo", "--for", "1s", *MEMORY, code=0, out="").err.splitlines()
    assert said[0].startswith("A Dingo robot drives through a warehouse")
    assert max(map(len, said[:10])) <= 80
    assert said[5:7] == ["  cp graphs/demo/round.yaml .", "  graphrun run round.yaml --view"]
    assert said[7].startswith("demo.yaml: 60 Hz, memory")
    assert not any("teleop" in line or "topic echo" in line for line in said[:7])
    assert said[-1].startswith("60 ticks, 1.000 s of simulation")


def test_a_file_called_demo_in_the_working_directory_does_not_change_the_demo(
    graphrun: Graphrun, project: Path
) -> None:
    (project / "demo").write_text("a file of the user's")
    said = graphrun("demo", "--for", "100ms", *MEMORY, code=0).err
    (graph,) = re.findall(r"  cp (.*) \.", said)
    assert Path(graph) == ROOT / "graphs/demo/round.yaml"


def test_a_copy_of_its_graph_runs_in_the_same_scene(graphrun: Graphrun, project: Path) -> None:
    text = (ROOT / "graphs/demo/round.yaml").read_text(encoding="utf-8")
    (project / "round.yaml").write_text(text.replace("values: [0.0, 0.6]", "values: [0.0, 0.4]"), encoding="utf-8")
    assert "round.yaml: 60 Hz" in graphrun("run", "round.yaml", "--for", "1s", *MEMORY[1:], code=0).err


def test_the_commands_of_the_demo_work_and_ctrl_c_ends_it(tmp_path: Path) -> None:
    assert [words[0] for words in TRIED] == ["teleop", "topic", "ctl", "ctl", "run"]
    own = {"XDG_RUNTIME_DIR": str(tmp_path)}
    with live("demo", *MEMORY, env=own) as run:
        assert run.hear(lambda said: " Hz, " in said)
        for words in TRIED:
            if words[0] == "ctl":
                result = process(*words, env=own)
                assert (result.code, result.err) == (0, ""), words
            else:  # they need a network, or the copy of the graph
                assert make_parser(words[0]).parse_args(words).verb == words[0]
        assert run.stop(signal.SIGINT) == 0
        assert "s of simulation" in run.said


def test_the_demo_names_topics_of_its_scene(graphrun: Graphrun) -> None:
    (topic,) = [words[-1] for words in TRIED if words[0] == "topic"]
    assert topic in graphrun("topics", "demo", code=0).out
    assert "/dd100_0000/cmd_vel" in graphrun("topics", "demo", code=0).out


def test_other_options_of_a_run_are_options_of_run(graphrun: Graphrun) -> None:
    assert "unrecognized arguments: --profile" in graphrun("demo", "--profile", code=2).err
    assert "`graphrun run demo`" in graphrun("demo", "--help", code=0).out


def test_the_demo_serves_a_page() -> None:
    pytest.importorskip("viser", reason="the extra view is not installed")
    with live("demo", *MEMORY[1:]) as run:
        assert run.hear(lambda said: re.search(r"see it: http://127\.0\.0\.1:\d+/#token=\S+\n", said) is not None)
        assert run.stop(signal.SIGINT) == 0
