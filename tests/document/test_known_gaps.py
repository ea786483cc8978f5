"""What ought to hold and does not yet. Whoever makes one of these pass removes its mark."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphengine import build

SCENE = "scene: s\nworld: w.xml\ngraphs:\n  clock: {use: graphs/clock.yaml, parameters: {rate: 10.0}}\n"
WORLD = '<mujoco><worldbody><geom type="plane" size="1 1 1"/></worldbody></mujoco>'


def told(folder: Path, text: str) -> list[str]:
    path = folder / "a.yaml"
    path.write_text(text)
    assembly = build.assemble(path)
    assembly.world.close()
    places = [
        (f.code, f.span.source.path, f.span.line) if f.span else (f.code, "", 0) for f in assembly.findings.errors
    ]
    return [f"{code} {Path(place).name}:{line}" for code, place, line in places]


@pytest.mark.xfail(strict=True, raises=TypeError, reason="template: the length of a default that is no path")
def test_a_target_parameter_whose_default_is_no_path_is_an_error(tmp_path: Path) -> None:
    assert told(tmp_path, "graph: g\nparameters: {robot: {type: target, default: 1}}\n") == ["G211 a.yaml:2"]


@pytest.mark.xfail(strict=True, reason="template: parameters are read before the format is")
def test_a_newer_format_is_one_error_whatever_its_parameters_are(tmp_path: Path) -> None:
    assert told(tmp_path, "format: 2\ngraph: g\nparameters: {robot: {type: prim}}\n") == ["G110 a.yaml:1"]


@pytest.mark.xfail(strict=True, reason="template: wires to a subgraph that could not be opened are told again")
def test_a_subgraph_that_is_not_there_is_one_error(tmp_path: Path) -> None:
    text = (
        "graph: g\nnodes:\n  Tick: OnPlaybackTick\n  Sub: {subgraph: s.yaml}\nconnections: [Tick.tick -> Sub.execIn]\n"
    )
    assert told(tmp_path, text) == ["G214 a.yaml:4"]


@pytest.mark.xfail(strict=True, reason="build: the place of a use is not handed on to the template")
def test_a_parameter_that_a_scene_gives_wrongly_is_told_in_the_scene(tmp_path: Path) -> None:
    (tmp_path / "w.xml").write_text(WORLD)
    assert told(tmp_path, SCENE) == ["G111 a.yaml:4"]


@pytest.mark.xfail(strict=True, reason="resolve: a required input that was given wrongly is called missing as well")
def test_a_required_input_of_a_wrong_type_is_one_error(tmp_path: Path) -> None:
    text = "graph: g\nnodes:\n  Tick: OnPlaybackTick\n  A: {type: IsaacComputeOdometry, inputs: {chassisPrim: 5}}\n"
    assert told(tmp_path, f"{text}connections: [Tick.tick -> A.execIn]\n") == ["G211 a.yaml:4"]
