"""What a shell limits, and files that are none: one line and an exit code, never a traceback, a signal or a hang."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.harness import Graphrun, Result, command, environment, process
from tests.waiting import PATIENCE

RUN = ("run", "dd100_flat", "--for", "100ms")


def limited(limit: str, *arguments: str) -> Result:
    """The program in a shell with a limit."""
    shell = ["sh", "-c", f'ulimit {limit} && exec "$@"', "sh", *command(*arguments)]
    done = subprocess.run(shell, env=environment(), capture_output=True, text=True, timeout=2 * PATIENCE, check=False)
    return Result(done.returncode, done.stdout, done.stderr)


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not limit address space")
@pytest.mark.parametrize("megabytes", [60, 150, 170, 200, 240, 270])
@pytest.mark.parametrize("transport", ["memory", "dds"])
def test_too_little_memory_has_its_own_exit_code(megabytes: int, transport: str) -> None:
    result = limited(f"-v {megabytes}000", *RUN, "--transport", transport)
    told = "error: out of memory: 320 MB of address space are needed; raise the limit of `ulimit -v`\n"
    assert (result.code, result.out, result.err) == (3, "", told)


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not limit address space")
def test_memory_that_suffices_for_a_run_but_not_for_dds_is_refused_before_cyclone_starts() -> None:
    result = limited("-v 420000", *RUN, "--transport", "dds")
    assert (result.code, result.out) == (1, "")
    assert "cannot join domain 0" in result.err
    assert "it needs 400 MB more memory\nraise the limit of `ulimit -v`" in result.err


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not limit address space")
def test_memory_that_does_not_suffice_for_opengl_is_refused_before_it_crashes(tmp_path: Path) -> None:
    result = limited("-v 1250000", "snapshot", "dd100_flat", "-o", str(tmp_path / "x.png"))
    told = "error: out of memory: rendering images needs 1100 MB of address space; raise the limit of `ulimit -v`\n"
    assert (result.code, result.out, result.err) == (3, "", told)


@pytest.mark.parametrize("files", [8, 16])
def test_a_lack_of_file_descriptors_for_dds_is_reported(files: int) -> None:
    result = limited(f"-n {files}", *RUN, "--transport", "dds")
    assert (result.code, result.out) == (1, "")
    assert result.err.endswith("it needs 24 more open files\nraise the limit of `ulimit -n`\n")


def test_a_lack_of_memory_in_a_verb_is_reported(graphrun: Graphrun, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr("graphengine.scene.build.load", full)
    assert graphrun("check", "dd100_flat") == Result(3, "", "error: out of memory\n")


@pytest.mark.parametrize("verb", [("check", "dd100_flat"), ("snapshot", "dd100_flat", "-o", "/nowhere/x.png")])
def test_an_unknown_opengl_setting_is_reported(verb: tuple[str, ...]) -> None:
    result = process(*verb, env={"MUJOCO_GL": "nonsense"}, code=2, out="")
    assert result.err.startswith(f"graphrun {verb[0]}: MUJOCO_GL=nonsense: not a value that MuJoCo knows\n  unset it")


VERBS = {
    "check": ["f.yaml"],
    "run": ["f.yaml"],
    "show": ["f.yaml"],
    "topics": ["f.yaml"],
    "map": ["f.yaml"],
    "snapshot": ["f.yaml", "-o", "x.png"],
    "export": ["f.yaml", "--to", "isaac-script"],
    "replay": ["f.mcap"],
    "import": ["f.py"],
    "import-robot": ["f.urdf", "-o", "x.yaml"],
}


@pytest.mark.parametrize("verb", ["run", "show", "topics"])
def test_a_folder_in_place_of_a_scene_is_refused_with_its_scenes(
    graphrun: Graphrun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, verb: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("home").mkdir()
    for name, text in {"a": "format: 1\nscene: a\n", "b": "scene: b\n", "c": "graph: c\nscene: a.yaml\n"}.items():
        Path("home", f"{name}.yaml").write_text(text)
    told = f"graphrun {verb}: home: a folder, not a file\n  try home/a.yaml or home/b.yaml\n"
    assert graphrun(verb, "home") == Result(2, "", told)


@pytest.mark.parametrize(
    ("verb", "kind"),
    [(verb, kind) for verb in VERBS for kind in ("pipe", "device", "folder") if (verb, kind) != ("check", "folder")],
)
def test_an_irregular_file_is_refused_at_once(
    graphrun: Graphrun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, verb: str, kind: str
) -> None:
    monkeypatch.chdir(tmp_path)
    given = Path(VERBS[verb][0])
    if kind == "pipe":
        os.mkfifo(given)
    elif kind == "device":
        given.symlink_to("/dev/zero")
    else:
        given.mkdir()
    result = graphrun(verb, *VERBS[verb], code=2, out="")
    folder = "a folder, not a file" in result.err or "Is a directory" in result.err
    assert folder if kind == "folder" else "not a regular file" in result.err
    assert "did you mean" not in result.err
