"""Scenes and graphs from mappings and texts: the same checks as for files, places that name keys, pickles and recordings."""

from __future__ import annotations

import pickle
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
import yaml

import graphengine as ge
from graphengine.cli import main
from graphengine.format.document import MAX_BYTES
from graphengine.format.given_text import GivenText

HEIGHT = 0.7  # m, at which the ball starts
FALL = "scene: fall\nworld: world.xml\ngraphs: {watch: {use: watch.yaml}}\n"
FILES = {
    "world.xml": f"""<mujoco><worldbody>
<body name="ball" pos="0 0 {HEIGHT}"><freejoint/><geom size=".1"/></body></worldbody></mujoco>""",
    "watch.yaml": "graph: watch\nnodes: {Tick: OnPlaybackTick}\n",
}
WHEELS = {"wheelRadius": 0.1, "wheelDistance": 0.5}  # m
GRAPH = {
    "graph": "g",
    "nodes": {"Tick": "OnPlaybackTick", "Diff": {"type": "DifferentialController", "inputs": WHEELS}},
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


def falling(scene: ge.Scene) -> tuple[list[str], float]:
    with scene.session() as sim:
        sim.run(0.25)
        return list(scene.graphs), float(sim.mujoco.data.body("ball").xpos[2])


@pytest.mark.parametrize("number", [float("inf"), float("-inf"), float("nan")])
def test_numbers_that_are_not_finite_are_those_of_yaml(number: float) -> None:
    given = {"one": number, "several": [number, 1.0], "text": "Infinity", "a: NaN": number}
    (read,) = yaml.safe_load_all(GivenText.of_mapping(given).data)
    assert repr(read) == repr(given)


def test_a_text_and_a_mapping_are_the_file(folder: Path) -> None:
    (folder / "scene.yaml").write_text(FALL, encoding="utf-8")
    expected = falling(ge.load(folder / "scene.yaml"))
    assert expected[1] == pytest.approx(HEIGHT - 9.81 / 2 * 0.25**2, abs=0.01)
    assert falling(ge.load(text=FALL, folder=folder)) == expected
    assert falling(ge.load(yaml.safe_load(FALL), folder=folder)) == expected


def test_relative_paths_start_from_the_working_directory_and_stay_below_the_folder(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    assert list(ge.load(text=FALL).graphs) == ["watch"]
    inner = folder / "inner"
    inner.mkdir()
    with pytest.raises(ge.CheckError, match=r"'\.\./world\.xml' lies outside the folder"):
        ge.load(text=FALL.replace("world.xml", "../world.xml"), folder=inner)


@pytest.mark.parametrize(
    ("change", "place", "code"),
    [
        ({"world": "wrld.xml"}, "<dict>: world", "S101"),
        ({"robots": {"bot": {"use": "bot.yaml"}}}, "<dict>: robots.bot.use", "S101"),
        ({"robots": {"bot": {"use": "world.xml", "position": [0, "x", 1]}}}, "<dict>: robots.bot.position[1]", "G108"),
        ({"robts": {}}, "<dict>: robts", "G106"),
        ({"graphs": {"watch": {}}}, "<dict>: graphs.watch", "G107"),
        ({"scene": None}, "<dict>: scene", "G108"),
    ],
)
def test_a_finding_in_a_mapping_names_the_key(folder: Path, change: Mapping[str, Any], place: str, code: str) -> None:
    with pytest.raises(ge.CheckError) as caught:
        ge.load({**yaml.safe_load(FALL), **change}, folder=folder)
    finding = caught.value.findings[0]
    assert (str(finding.span), finding.code) == (place, code)
    assert finding.render().startswith(f"{place}: error {code}: ")


def test_findings_in_graphs_and_in_texts_have_their_places() -> None:
    with pytest.raises(ge.CheckError) as caught:
        ge.load({**GRAPH, "connections": ["Tick.tick -> Diff.execute"]})
    assert str(caught.value.findings[0].span) == "<dict>: connections[0]"
    with pytest.raises(ge.CheckError) as caught:
        ge.load(text="graph: g\nnodes:\n  Tick: OnPlaybackTikc\n")
    assert str(caught.value.findings[0].span) == "<text>:3:9"
    with pytest.raises(ge.CheckError) as caught:
        ge.load({})
    assert str(caught.value.findings[0].span) == "<dict>"
    with pytest.raises(ge.CheckError, match="larger than 8 MB"):
        ge.load(text="#" * (MAX_BYTES + 1))
    with pytest.raises(ge.CheckError, match="not UTF-8"):
        ge.load(text="graph: \ud800")


@pytest.mark.parametrize(
    "text", ["1e5", "0o17", "null", "~", "yes", "2020-01-01", "- a", "a: b", "'", '"', "é\n#", "\u2028\x85🐧"]
)
def test_every_string_of_a_mapping_stays_a_string(text: str) -> None:
    variables = {"said": {"type": "string", "default": text}}
    with ge.load({"graph": "g", "nodes": {"Tick": "OnPlaybackTick"}, "variables": variables}).session() as sim:
        assert sim.variables("g") == {"said": text}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({}, "give either a file, a mapping, or `text`"),
        ({"source": GRAPH, "text": "graph: g"}, "give either a file, a mapping, or `text`"),
        ({"source": "dd100_flat", "folder": "."}, "folder: only with a mapping or `text`"),
        ({"source": GRAPH, "folder": "nowhere"}, "there is no folder nowhere"),
        ({"source": {**GRAPH, "nodes": {"Tick": object()}}}, "expected a number, string"),
    ],
)
def test_arguments_that_do_not_fit_are_refused(arguments: Any, words: str) -> None:
    with pytest.raises(ge.UsageError, match=words):
        ge.load(**arguments)


def test_it_is_pickled_recorded_and_replayed_without_the_folder(folder: Path, tmp_path_factory: Any) -> None:
    scene = ge.load(yaml.safe_load(FALL), folder=folder)
    recording = tmp_path_factory.mktemp("elsewhere") / "run.mcap"
    with scene.session(record=recording) as sim:
        sim.run(0.2)
        (folder / "watch.yaml").write_text(FILES["watch.yaml"].replace("Tick:", "Tock:"), encoding="utf-8")
        assert sim.reload().changed == ("watch",)
        sim.step()
        assert sim.value("watch/Tock.frame") == 13
    data, expected = pickle.dumps(scene), falling(scene)
    for path in folder.iterdir():
        path.unlink()
    assert falling(pickle.loads(data)) == expected
    assert main(["replay", str(recording)]) == 0


def test_a_graph_from_a_mapping_runs_in_a_scene_and_takes_set_values() -> None:
    scene = ge.load(GRAPH, scene="dd100_flat", set={"Diff.wheelRadius": 0.25})
    with scene.session() as sim:
        assert sim.value("g/Diff.wheelRadius") == 0.25
        assert list(sim.robots) == ["dd100"]
