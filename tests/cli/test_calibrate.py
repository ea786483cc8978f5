"""`graphrun calibrate`."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.bringup.calibration import bases
from tests.cli.harness import Graphrun


def test_calibrate_prints_the_speeds_that_the_dingo_reaches(graphrun: Graphrun) -> None:
    result = graphrun("calibrate", "dd100_flat", "--check")
    assert result.lines[0] == "dd100: /dd100_0000/cmd_vel (geometry_msgs/msg/Twist), differential"
    (forward,) = [line.split() for line in result.lines if line.startswith("forward")]
    assert forward[1:6] == ["0.3", "m/s", "0.3000", "m/s", "99.98"]
    assert "wheel radius    0.04899 m, 2 wheels" in result.lines


def test_json_is_the_data_of_the_calibration(graphrun: Graphrun) -> None:
    data = json.loads(graphrun("calibrate", "dd100_flat", "--format", "json", "--speed", "0.5").out)
    assert data["robot"] == "dd100"
    assert data["motions"][0]["commanded"] == {"x": 0.5, "y": 0.0, "yaw": 0.0}
    assert data["motions"][0]["share"] == pytest.approx(1.0, abs=0.001)
    assert data["wheel_base"] is None


def test_a_robot_that_fails_the_check_passes_after_write(graphrun: Graphrun, tmp_path: Path) -> None:
    scene = str(bases.differential(tmp_path, radius=1.1 * bases.RADIUS).write().scene)
    result = graphrun("calibrate", scene, "--check", "0.02", "--write", code=1)
    assert "forward: 90.4" in result.err
    assert "of the commanded speed; the difference may be at most 2.00 %" in result.err
    assert "bot.yaml: drive/DiffController.wheelRadius: 0.055 -> 0.0497" in result.err
    graphrun("calibrate", scene, "--check", "0.005")


def test_the_picture_is_written(graphrun: Graphrun, tmp_path: Path) -> None:
    picture = tmp_path / "square.svg"
    result = graphrun("calibrate", str(bases.ackermann(tmp_path / "car").write().scene), "--picture", str(picture))
    assert "the square in both directions" in result.err
    assert picture.read_text(encoding="utf-8").startswith("<svg")


def test_a_robot_that_does_not_move_is_an_error_with_the_reason(graphrun: Graphrun, tmp_path: Path) -> None:
    base = bases.differential(tmp_path)
    base.graphs.clear()
    result = graphrun("calibrate", str(base.write().scene), code=1)
    assert result.lines[0] == "bot cannot be calibrated"
    assert result.lines[1].startswith("  no command topic")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("dd100_flat", "--picture", "square.png"), "write the name of an SVG file"),
        (("dd100_flat", "--check", "0"), "write a number above 0"),
        (("dd100_flat", "--robot", "dd10"), "did you mean 'dd100'?"),
        (("dd100_flat", "--speed", "-1"), "speed: expected a number above 0"),
        (("clock",), "there is no robot to calibrate"),
        (("nowhere",), "no file 'nowhere'"),
    ],
)
def test_contradictory_options_are_refused(graphrun: Graphrun, arguments: tuple[str, ...], message: str) -> None:
    assert message in graphrun("calibrate", *arguments, code=2, out="").err
