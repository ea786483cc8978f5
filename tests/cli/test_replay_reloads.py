"""Recordings of runs whose files changed: a replay follows them from the recording alone."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from graphengine.format.diagnostics import CheckError
from graphengine.runtime.commands import parse
from graphengine.scene.loaded_scene import Options
from tests.cli.harness import Graphrun
from tests.jobs.harness import ROOT
from tests.recording.harness import DRIVE, Run, record, rewritten

CMD_VEL = "graphs/dd100/cmd_vel.yaml"
SCENE = "scenes/dd100_flat.yaml"


@pytest.fixture
def library(tmp_path: Path) -> Path:
    """A copy of the graphs and scenes that ship, which can be changed."""
    for name in ("graphs", "scenes"):
        shutil.copytree(ROOT / name, tmp_path / "library" / name)
    return tmp_path / "library"


class Edits:
    """Edits files of a run, and reloads them."""

    def __init__(self, library: Path) -> None:
        self.library = library
        self.refused = 0
        self.restarted = 0

    def edit(self, file: str, old: str, new: str) -> None:
        path = self.library / file
        text = path.read_text(encoding="utf-8")
        assert old in text, old
        path.write_text(text.replace(old, new), encoding="utf-8")

    def reload(self, run: Run) -> None:
        try:
            self.restarted += run.session.reload().restarted
        except CheckError:
            self.refused += 1

    def before(self, tick: int, run: Run) -> None:
        """What is done before each tick: graphs change, have errors and are mended, come and go, and the world changes."""
        changes = {
            20: [(CMD_VEL, "maxLinearSpeed: 1.3", "maxLinearSpeed: 0.4")],
            30: [(CMD_VEL, "maxLinearSpeed", "maxLinearSped")],
            35: [(CMD_VEL, "maxLinearSped", "maxLinearSpeed")],
            45: [(SCENE, "graphs/clock.yaml", "another.yaml")],
            60: [(SCENE, "position: [0", "position: [1")],
            80: [(CMD_VEL, "maxLinearSpeed: 0.4", "maxLinearSpeed: 1.0"), (SCENE, "another.yaml", "graphs/clock.yaml")],
        }
        if tick == 45:
            shutil.copyfile(self.library / "graphs/clock.yaml", self.library / "scenes/another.yaml")
        for file, old, new in changes.get(tick, ()):
            self.edit(file, old, new)
        if tick == 80:
            (self.library / "scenes/another.yaml").unlink()
        if tick in changes or tick in (50, 70):
            self.reload(run)


@pytest.fixture
def edits(library: Path) -> Edits:
    return Edits(library)


def recorded(tmp_path: Path, edits: Edits, **how: object) -> Path:
    path = tmp_path / "out.mcap"
    record(path, 140, edits.library / SCENE, commands=DRIVE, options=Options(shipped=edits.library), **how)  # type: ignore[arg-type]
    return path


def test_a_replay_follows_changes_errors_and_restarts_without_the_files(
    tmp_path: Path, edits: Edits, graphrun: Graphrun
) -> None:
    path = recorded(tmp_path, edits, before=edits.before)
    assert (edits.refused, edits.restarted) == (1, 1)
    shutil.rmtree(edits.library)
    result = graphrun("replay", str(path), code=0)
    assert result.out.startswith("identical: ")
    assert result.out.endswith(" in 140 ticks, 2.333 s\n")


def test_a_reload_of_a_spawned_robot_is_replayed(tmp_path: Path, edits: Edits, graphrun: Graphrun) -> None:
    def before(tick: int, run: Run) -> None:
        if tick == 5:
            (edits.library / "scenes/own.yaml").write_text(
                "robot: own\nextends: robots/dd100.yaml\ngraphs: {more: {use: more.yaml}}\n", encoding="utf-8"
            )
            clock = (edits.library / "graphs/clock.yaml").read_text(encoding="utf-8")
            (edits.library / "scenes/more.yaml").write_text(
                clock.replace("graph: clock", "graph: more").replace("/World/clock", "/late/more"), encoding="utf-8"
            )
            run.session.reload()
        if tick == 6:
            use = {"use": "own.yaml", "position": [2, 2, 0.025], "namespace": "late"}
            parse("spawn", {"name": "late", "use": use}).apply(run.session)
        if tick == 20:
            edits.edit("scenes/more.yaml", "nodes:\n", "nodes:\n  Spare: ConstantDouble\n")
            assert run.session.reload().changed == ("late/more",)

    path = recorded(tmp_path, edits, before=before)
    shutil.rmtree(edits.library)
    assert graphrun("replay", str(path), code=0).out.startswith("identical: ")


def test_reloading_unchanged_files_leaves_no_trace(tmp_path: Path, edits: Edits) -> None:
    plain = recorded(tmp_path, edits).read_bytes()

    def before(tick: int, run: Run) -> None:
        if tick == 30:
            (edits.library / CMD_VEL).touch()
        if tick % 30 == 0:
            run.session.reload()

    assert recorded(tmp_path, edits, before=before, force=True).read_bytes() == plain


def test_a_reload_of_a_comment_is_recorded(tmp_path: Path, edits: Edits, graphrun: Graphrun) -> None:
    def before(tick: int, run: Run) -> None:
        if tick == 30:
            edits.edit(CMD_VEL, "format: 1", "format: 1  # a comment")
            assert run.session.reload().changed == ()

    path = recorded(tmp_path, edits, before=before)
    assert b"a comment" in path.read_bytes()
    assert graphrun("replay", str(path), code=0).out.startswith("identical: ")


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        ('{"files": 3}', "has no valid list of files"),
        ('{"files": {"project/a.yaml": 1}}', "has no valid list of files"),
        ("[]", "has no valid list of files"),
        ('{"files": {"../a.yaml": null}}', "is not a legal name for a file of a recording"),
        ('{"files": {"project/a.yaml": "/etc/passwd"}}', "is not a legal name for a file of a recording"),
        (
            '{"files": {"project/a.yaml": "project/none.yaml"}}',
            "lacks the file 'project/none.yaml', which a reload read",
        ),
    ],
)
def test_a_forged_reload_reads_no_files_outside_of_the_recording(
    tmp_path: Path, clock: Path, graphrun: Graphrun, arguments: str, why: str
) -> None:
    path = tmp_path / "out.mcap"
    record(path, 5, clock)
    bad = rewritten(path, commands=f'{{"commands": [["reload", {arguments}]]}}')
    assert why in graphrun("replay", str(bad), code=2).err
