"""The findings that docs/help/symptoms.md prints are those of a project of `graphrun new`, broken as the page says."""

from __future__ import annotations

from pathlib import Path

import pytest

import graphengine as ge
from tests.cli.harness import ROOT, process
from tests.readme.test_readme import blocks

PAGE = (ROOT / "docs/help/symptoms.md").read_text(encoding="utf-8")
PRINTED = [block.splitlines() for block in blocks(PAGE, "console")]
ROBOT, GRAPH, SCENE = "robots/bot.yaml", "graphs/cmd_vel.yaml", "bot.yaml"
LEFT, RIGHT = "front_left_wheel_joint", "front_right_wheel_joint"


def joints(**drives: str) -> tuple[str, str]:
    """Replacement that gives the robot file drives of joints."""
    lines = "".join(f"  {joint}: {{drive: {{{drive}}}}}\n" for joint, drive in drives.items())
    return "graphs:\n", f"joints:\n{lines}graphs:\n"


BREAKS = {
    "W208": (ROBOT, "{use: ../graphs/cmd_vel.yaml}", "{use: graphs/dd100/scan.yaml}"),
    "W101": (GRAPH, "  - OnPlaybackTick.tick -> ArtController.execIn\n", ""),
    "G310": (ROBOT, *joints(**{LEFT: "damping: 0.0"})),
    "N103": (ROBOT, *joints(**{LEFT: "damping: 50.0, max_force: 0.001"})),
    "W201": (GRAPH, "wheelRadius: 0.049 ", "wheelRadius: 0.1 "),
}


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the project `bot`."""
    folder = tmp_path_factory.mktemp("symptoms") / "bot"
    process("new", str(folder), code=0)
    return folder


@pytest.mark.parametrize("code", BREAKS)
def test_a_broken_project_has_the_finding_that_the_page_prints(code: str, project: Path) -> None:
    name, before, after = BREAKS[code]
    text = (project / name).read_text(encoding="utf-8")
    assert before in text
    (project / name).write_text(text.replace(before, after), encoding="utf-8")
    try:
        found = process("check", SCENE, cwd=project).out.splitlines()
    finally:
        (project / name).write_text(text, encoding="utf-8")
    missing = [set(lines) - set(found) for lines in PRINTED if f" {code}: " in lines[0]]
    assert set() in missing, missing


def test_wheels_with_stiffness_hold_and_are_told(project: Path) -> None:
    text = (project / ROBOT).read_text(encoding="utf-8")
    spring = "damping: 50.0, stiffness: 100.0"
    (project / ROBOT).write_text(text.replace(*joints(**{LEFT: spring, RIGHT: spring})), encoding="utf-8")
    try:
        scene = ge.load(project / SCENE)
    finally:
        (project / ROBOT).write_text(text, encoding="utf-8")
    assert "`check` reports such drives (W214)" in " ".join(PAGE.split())
    assert [finding.code for finding in scene.findings if finding.code.startswith(("W", "G"))] == ["W214"]
    with scene.session() as sim:
        sim.robots["bot"].publish("cmd_vel", {"linear": {"x": 0.5}}, every=0.1)
        sim.run(3.0)
        assert sim.robots["bot"].velocity.linear[0] < 0.05


def test_a_command_beyond_a_drive_is_clamped_with_the_words_of_the_page(
    project: Path, caplog: pytest.LogCaptureFixture
) -> None:
    text = (project / ROBOT).read_text(encoding="utf-8")
    slow = "damping: 50.0, max_velocity: 5.0"
    (project / ROBOT).write_text(text.replace(*joints(**{LEFT: slow})), encoding="utf-8")
    try:
        scene = ge.load(project / SCENE)
    finally:
        (project / ROBOT).write_text(text, encoding="utf-8")
    with scene.session() as sim:
        sim.robots["bot"].publish("cmd_vel", {"linear": {"x": 0.8}}, every=0.1)
        sim.run(1.5)
    [shown] = [lines for lines in PRINTED if lines[0].startswith("warning: commands are clamped")]
    assert f"warning: {caplog.messages[0]}".splitlines() == shown
