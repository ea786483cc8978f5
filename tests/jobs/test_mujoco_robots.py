"""Robots from MuJoCo models behave as those from other descriptions: a base on wheels, a robot that stands on legs."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphengine.cli import main
from tests.bringup.robots.imported_bases import DIFFERENTIAL
from tests.jobs.harness import Job
from tests.jobs.test_imported_bases import driven, moved
from tests.physics.mjcf_models import DIFFERENTIAL as MODEL
from tests.physics.mjcf_models import QUADRUPED, write_model


def imported(folder: Path, text: str, scene: str = "settle: true\n", position: str = "[0, 0, 0.051]") -> Path:
    """Import a model by the command line; return a scene with it."""
    write_model(folder, "bot.xml", text)
    assert main(["import-robot", str(folder / "bot.xml"), "-o", str(folder / "bot.yaml")]) == 0
    robots = f"robots: {{bot: {{use: bot.yaml, position: {position}}}}}\n"
    (folder / "scene.yaml").write_text(f"scene: s\nworld: worlds/flat_grid.xml\n{scene}{robots}", encoding="utf-8")
    return folder / "scene.yaml"


@pytest.mark.parametrize("command", [(0.5, 0.0, 0.0), (0.0, 0.0, 0.8), (0.3, 0.0, -0.4)])
def test_a_differential_base_moves_alike_as_mjcf_and_as_urdf(
    tmp_path: Path, command: tuple[float, float, float], capsys: pytest.CaptureFixture[str]
) -> None:
    ahead, _, turned = moved(imported(tmp_path, MODEL), command)
    assert "guessed: base: differential" in capsys.readouterr().out
    expected, _, turn = driven(tmp_path, DIFFERENTIAL, command)
    assert (ahead, turned) == pytest.approx((expected, turn), rel=0.01, abs=0.001)


def test_a_robot_on_legs_stands_in_its_keyframe_also_after_a_push(tmp_path: Path) -> None:
    path = imported(tmp_path, QUADRUPED, scene="", position="[0, 0, 0]")
    with Job(path) as job:
        world = job.session.services.world
        heights = []
        for second in range(10):
            if second == 5:
                world.entities.push("bot", (0.0, 50.0, 0.0), 0.1)
            job.run(1.0)
            heights.append(world.entities.state("bot").position[2])
    assert heights == pytest.approx([0.27] * 10, abs=0.02)


def test_the_messages_of_a_model_have_the_names_of_its_joints(tmp_path: Path) -> None:
    path = imported(tmp_path, QUADRUPED, scene="", position="[0, 0, 0]")
    text = path.read_text(encoding="utf-8").replace("position:", "robot_state: true, position:")
    path.write_text(text, encoding="utf-8")
    with Job(path) as job:
        job.run(0.2)
        description = job.heard("/robot_description")[0].data
        transforms = {(t.header.frame_id, t.child_frame_id) for m in job.heard("/tf") for t in m.transforms}
        fixed = {(t.header.frame_id, t.child_frame_id) for m in job.heard("/tf_static") for t in m.transforms}
    assert '<joint name="FL_calf_joint" type="revolute">' in description
    assert ("FL_thigh", "FL_calf") in transforms
    assert fixed == {("trunk", "imu")}
