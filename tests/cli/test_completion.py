"""What shells complete, asked of the shells themselves."""

from __future__ import annotations

import os
import pty
import select
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from graphengine.cli import VERBS
from graphengine.cli.completion import SHELLS
from tests.cli.harness import SCENES, Graphrun, command, environment, live
from tests.waiting import PATIENCE

Complete = Callable[..., list[str]]
BASH = """
source completion.bash
COMP_WORDS=(graphrun "$@")
COMP_CWORD=$#
_shtab_graphrun
printf '%s\\n' "${COMPREPLY[@]}"
"""


def needs(shell: str) -> pytest.MarkDecorator:
    return pytest.mark.skipif(shutil.which(shell) is None, reason=f"{shell} is not installed")


@pytest.fixture
def folder(tmp_path: Path, graphrun: Graphrun) -> Path:
    """A folder with the scripts of all shells, and files to complete."""
    for shell in SHELLS:
        script = graphrun("completion", shell, code=0, err="").out
        (tmp_path / f"completion.{shell}").write_text(script, encoding="utf-8")
    for name in ("my_scene.yaml", "my_notes.txt", "my_run.mcap"):
        (tmp_path / name).touch()
    (tmp_path / "my_folder").mkdir()
    program = tmp_path / "bin" / "graphrun"
    program.parent.mkdir()
    program.write_text("#!/bin/sh\nexec " + " ".join(command()) + ' "$@"\n', encoding="utf-8")
    program.chmod(0o755)
    return tmp_path


@pytest.fixture
def bash(folder: Path) -> Complete:
    def complete(*words: str) -> list[str]:
        """The completions of the last word."""
        path = f"{folder / 'bin'}:{os.environ['PATH']}"
        done = subprocess.run(
            ["bash", "--norc", "-c", BASH, "bash", *words],
            cwd=folder,
            env=environment({"PATH": path}),
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=True,
        )
        assert done.stderr == ""
        return done.stdout.split()

    return complete


@needs("bash")
def test_bash_completes_verbs_options_and_choices(bash: Complete) -> None:
    assert bash("") == [*VERBS, "test"]  # a verb by entry point
    assert bash("rep") == ["replay"]
    assert bash("run", "--tr") == ["--transport"]
    assert sorted(bash("run", "dd100_flat", "--transport", "")) == ["auto", "dds", "memory", "rclpy"]
    assert bash("topic", "e") == ["echo"]
    assert bash("topic", "echo", "--no-a") == ["--no-arr"]
    assert bash("ctl", "sp") == ["spawn"]
    assert bash("schema", "") == ["graph", "scene", "robot"]


@needs("bash")
def test_bash_completes_scenes_by_name_and_files_of_the_folder(bash: Complete) -> None:
    assert set(SCENES) <= set(bash("map", ""))
    assert bash("run", "dd100_w") == ["dd100_warehouse"]
    assert bash("run", "dd100/c") == ["dd100/cmd_vel"]
    assert bash("import-robot", "my_n") == ["my_notes.txt"]
    assert bash("map", "my_") == ["my_scene.yaml", "my_folder"]
    assert bash("run", "dd100/cmd_vel", "--scene", "tutorial/n") == ["tutorial/navigation"]
    assert "dd100/cmd_vel" not in bash("run", "--scene", "")
    assert "robots/dd100" not in bash("run", "")
    assert bash("replay", "my_r") == ["my_run.mcap"]


@needs("bash")
def test_bash_completes_node_types_by_their_registered_and_short_names(bash: Complete) -> None:
    assert bash("nodes", "OnPlayb") == ["OnPlaybackTick"]
    assert bash("nodes", "omni.graph.action.OnPlayb") == ["omni.graph.action.OnPlaybackTick"]


@needs("bash")
def test_bash_completes_every_code_to_explain(bash: Complete) -> None:
    assert bash("explain", "W30") == ["W301", "W302", "W303"]
    assert bash("explain", "W301", "G40") == ["G401", "G402"]


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A run that `graphrun ctl` reaches, and no other."""
    with tempfile.TemporaryDirectory(prefix="graphrun-test-") as runtime:
        monkeypatch.setenv("XDG_RUNTIME_DIR", runtime)
        with live("run", "dd100_flat", "--paused", "--transport", "memory") as process:
            assert process.hear(lambda said: " Hz, " in said)
            yield


@needs("bash")
def test_bash_completes_the_topics_of_the_run(bash: Complete, run: None) -> None:
    assert bash("topic", "echo", "/cl") == ["/clock"]
    assert bash("topic", "echo", "--once", "/dd100_0000/c") == ["/dd100_0000/cmd_vel"]


@needs("bash")
def test_completion_without_a_run_offers_no_topics(
    bash: Complete, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    assert bash("topic", "echo", "/cl") == []


def typed(folder: Path, line: str, wanted: str, load: str = 'eval "$(<completion.zsh)"') -> str:
    """What zsh shows after a line with a tab at its end, as soon as that is what is wanted; `load` loads the script."""
    terminal, inner = pty.openpty()
    env = environment({"TERM": "xterm", "PATH": f"{folder / 'bin'}:{os.environ['PATH']}", "PS1": "ready> "})
    shell = subprocess.Popen(
        ["zsh", "-f", "-i"], cwd=folder, env=env, stdin=inner, stdout=inner, stderr=inner, start_new_session=True
    )
    os.close(inner)
    said = ""

    def hear(text: str) -> str:
        nonlocal said
        deadline = time.monotonic() + PATIENCE
        while text not in said and time.monotonic() < deadline and shell.poll() is None:
            if select.select([terminal], [], [], 0.1)[0]:
                said += os.read(terminal, 65536).decode(errors="replace")
        return said

    try:
        hear("ready> ")
        loads = f"autoload -Uz compinit && compinit -u -D; {load}; echo loaded $((40 + 2))\n"
        os.write(terminal, loads.encode())
        hear("loaded 42")
        said = ""
        os.write(terminal, f"{line}\t".encode())
        return hear(wanted)
    finally:
        shell.kill()
        shell.wait()
        os.close(terminal)


@needs("zsh")
@pytest.mark.parametrize(
    ("line", "completed"),
    [
        ("graphrun rep", "graphrun replay"),
        ("graphrun run --tr", "--transport"),
        ("graphrun run dd100_w", "dd100_warehouse"),
        ("graphrun run my_s", "my_scene.yaml"),
        ("graphrun nodes OnPlayb", "OnPlaybackTick"),
        ("graphrun run dd100_flat --transport mem", "--transport memory"),
    ],
)
def test_zsh_completes(folder: Path, line: str, completed: str) -> None:
    assert completed in typed(folder, line, completed)


@needs("zsh")
@pytest.mark.parametrize("load", ["source completion.zsh", "source <(cat completion.zsh)"])
def test_zsh_completes_after_the_script_was_sourced(folder: Path, load: str) -> None:
    assert "graphrun replay" in typed(folder, "graphrun rep", "graphrun replay", load)


@needs("zsh")
def test_zsh_completes_the_topics_of_the_run(folder: Path, run: None) -> None:
    assert "/clock" in typed(folder, "graphrun topic hz /cl", "/clock")


@needs("fish")
def test_fish_completes(folder: Path) -> None:
    def complete(line: str) -> list[str]:
        script = f"source completion.fish; complete -C '{line}'"
        done = subprocess.run(
            ["fish", "--no-config", "-c", script], cwd=folder, capture_output=True, text=True, check=True
        )
        return [found.partition("\t")[0] for found in done.stdout.splitlines()]

    assert complete("graphrun rep") == ["replay"]
    assert complete("graphrun run dd100_w") == ["dd100_warehouse"]
    assert complete("graphrun nodes OnPlayb") == ["OnPlaybackTick"]


def test_an_unknown_shell_is_refused_with_the_known_shells(graphrun: Graphrun) -> None:
    result = graphrun("completion", "bsh", code=2, out="")
    assert "did you mean 'bash'?" in result.err


@needs("bash")
def test_no_command_in_the_name_of_a_topic_is_run(folder: Path, bash: Complete) -> None:
    (folder / "bin" / "graphrun").write_text("#!/bin/sh\necho '/a' '$(touch${IFS}ran)'\n", encoding="utf-8")
    found = bash("topic", "echo", "/")
    assert "/a" in found
    assert not (folder / "ran").exists()
