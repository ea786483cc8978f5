"""Values of inputs and positions of nodes are written into the files of a scene, and undone byte by byte."""

from __future__ import annotations

import os
import random
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import graphengine as ge
from graphengine.api.run_options import RunOptions
from graphengine.api.runner import Runner
from graphengine.api.scene import start_runner
from graphengine.format.diagnostics import Findings
from graphengine.format.document import parse
from graphengine.format.errors import RecordingError, StateError, UsageError
from graphengine.scene.value_edits import Change, ValueEdits

ROOT = Path(__file__).resolve().parents[2]
SHIPPED = sorted((ROOT / "graphs").rglob("*.yaml"))
INNER = """graph: inner
parameters:
  speed: {type: double, default: 0.5}
nodes:
  Own: {type: ConstantDouble, inputs: {value: 0.25}}  # own
  Speed: {type: ConstantDouble, inputs: {value: $(speed)}}
"""
OUTER = """format: 1
graph: outer  # the whole
parameters:
  speed: {type: double, default: 1.5}
nodes:
  Tick: OnPlaybackTick
  Limit: {type: ConstantDouble, inputs: {value: 1.3}}  # m/s
  Given: {type: ConstantDouble, inputs: {value: $(speed)}}
  List: {type: ConstantDouble3, inputs: {value: [1.0, 2.0, 3.0]}}
  Short: ConstantDouble
  Left: {subgraph: inner.yaml, parameters: {speed: 0.75}}
  Right: {subgraph: inner.yaml}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "inner.yaml").write_text(INNER, encoding="utf-8")
    (tmp_path / "outer.yaml").write_text(OUTER, encoding="utf-8")
    return tmp_path


@pytest.fixture
def run(folder: Path) -> Iterator[Runner]:
    with start_runner(ge.load(folder / "outer.yaml"), RunOptions(edit=True)) as runner:
        yield runner


def texts(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*.yaml"))}


def value(run: Runner, node: str) -> Any:
    (graph,) = run.session.graphs
    return graph.executor.node(node).value  # type: ignore[attr-defined]


def lines_that_differ(before: str, after: str) -> list[str]:
    pairs = zip(before.splitlines(), after.splitlines(), strict=True)
    return [new for old, new in pairs if old != new]


@pytest.mark.parametrize(
    ("address", "new", "text", "file", "line"),
    [
        (
            "Limit.value",
            0.2,
            "value: 1.3 -> 0.2 in outer.yaml:7",
            "outer.yaml",
            "Limit: {type: ConstantDouble, inputs: {value: 0.2}}  # m/s",
        ),
        (
            "Given.value",
            2.0,
            "value: 1.5 -> 2.0 in outer.yaml:4, through $(speed)",
            "outer.yaml",
            "speed: {type: double, default: 2.0}",
        ),
        (
            "List.value",
            [1.0, 0.0, 0.0],
            "value: [1.0, 2.0, 3.0] -> [1.0, 0.0, 0.0] in outer.yaml:9",
            "outer.yaml",
            "List: {type: ConstantDouble3, inputs: {value: [1.0, 0.0, 0.0]}}",
        ),
        (
            "Short.value",
            4.0,
            "value: not set -> 4.0 in outer.yaml:10, a new key",
            "outer.yaml",
            "Short: {type: ConstantDouble, inputs: {value: 4.0}}",
        ),
        (
            "Left/Speed.value",
            0.8,
            "value: 0.75 -> 0.8 in outer.yaml:11, through $(speed)",
            "outer.yaml",
            "Left: {subgraph: inner.yaml, parameters: {speed: 0.8}}",
        ),
        (
            "Right/Speed.value",
            0.6,
            "value: 0.5 -> 0.6 in inner.yaml:3, through $(speed), for 2 nodes",
            "inner.yaml",
            "speed: {type: double, default: 0.6}",
        ),
        (
            "Left/Own.value",
            0.3,
            "value: 0.25 -> 0.3 in inner.yaml:5, for 2 nodes",
            "inner.yaml",
            "Own: {type: ConstantDouble, inputs: {value: 0.3}}  # own",
        ),
    ],
)
def test_a_value_is_written_where_it_comes_from_and_only_its_line_changes(
    run: Runner, folder: Path, address: str, new: Any, text: str, file: str, line: str
) -> None:
    before = texts(folder)
    told = run.command("save", address=address, value=new)["text"]
    assert told.replace(f"{folder}/", "") == text
    after = texts(folder)
    assert [lines.strip() for lines in lines_that_differ(before[file].decode(), after[file].decode())] == [line]
    assert {name for name in before if before[name] != after[name]} == {file}
    assert value(run, address.removesuffix(".value")) == pytest.approx(new)
    assert run.command("undo")["text"] == told
    assert texts(folder) == before
    assert run.command("redo")["text"] == told
    assert texts(folder) == after


def test_a_preview_writes_nothing_and_needs_no_permission(folder: Path) -> None:
    before = texts(folder)
    with start_runner(ge.load(folder / "outer.yaml"), RunOptions()) as run:
        assert run.command("save", address="Limit.value", value=0.2, preview=True)["text"].startswith(
            "value: 1.3 -> 0.2 in "
        )
        with pytest.raises(StateError, match="start it with --edit"):
            run.command("save", address="Limit.value", value=0.2)
        with pytest.raises(StateError, match="start it with --edit"):
            run.command("undo")
    assert texts(folder) == before


def test_the_present_value_is_written_if_none_is_given(run: Runner, folder: Path) -> None:
    run.command("set", address="Limit.value", value=0.4)
    run.command("save", address="Limit.value")
    assert "inputs: {value: 0.4}}  # m/s" in (folder / "outer.yaml").read_text(encoding="utf-8")
    assert value(run, "Limit") == 0.4


def test_a_position_of_a_node_is_written_to_the_layout(run: Runner, folder: Path) -> None:
    before = texts(folder)
    run.command("place", graph="outer", node="Limit", position=[120.04, -3.0])
    run.command("place", graph="outer", node="Tick", position=[0, 0])
    run.command("place", graph="outer", node="Limit", position=[130.0, -3.0])
    written = (folder / "outer.yaml").read_text(encoding="utf-8")
    assert written == OUTER + "layout: {Limit: [130.0, -3.0], Tick: [0.0, 0.0]}\n"
    for _ in range(3):
        run.command("undo")
    assert texts(folder) == before


def test_a_value_with_an_error_is_refused_and_nothing_is_written(run: Runner, folder: Path) -> None:
    before = texts(folder)
    for wrong in ("north", [1.0], {"a": 1}):
        with pytest.raises(UsageError, match="is a double"):
            run.command("save", address="Limit.value", value=wrong)
    assert texts(folder) == before


def test_a_change_that_the_scene_refuses_is_taken_back(run: Runner, folder: Path) -> None:
    before = texts(folder)
    (folder / "inner.yaml").write_text(INNER.replace("double", "duble"), encoding="utf-8")  # an editor left an error
    broken = texts(folder)
    with pytest.raises(ge.CheckError):
        run.command("save", address="Limit.value", value=0.2)
    assert texts(folder) == broken
    assert value(run, "Limit") == 1.3
    assert broken["outer.yaml"] == before["outer.yaml"]


def reload_once_then(error: BaseException, before_error: Any = None) -> Any:
    errors = iter([error])

    def reload() -> None:
        for found in errors:
            if before_error is not None:
                before_error()
            raise found

    return reload


@pytest.mark.parametrize("error", [ge.GraphError("refused"), ZeroDivisionError(), KeyboardInterrupt()])
def test_a_file_has_its_old_text_after_any_error_of_the_reload(error: BaseException, tmp_path: Path) -> None:
    path = tmp_path.resolve() / "a.yaml"
    path.write_bytes(b"a: 1")
    edits = ValueEdits(reload_once_then(error))
    with pytest.raises(type(error)):
        edits.write(Change(path, b"a: 1", b"a: 2", ""))
    assert path.read_bytes() == b"a: 1"
    edits.write(Change(path, b"a: 1", b"a: 3", ""))
    assert path.read_bytes() == b"a: 3"


def test_an_error_of_the_recording_after_the_reload_keeps_the_change(tmp_path: Path) -> None:
    path = tmp_path.resolve() / "a.yaml"
    path.write_bytes(b"a: 1")
    with pytest.raises(RecordingError):
        ValueEdits(reload_once_then(RecordingError("no space"))).write(Change(path, b"a: 1", b"a: 2", ""))
    assert path.read_bytes() == b"a: 2"


def test_a_refused_reload_keeps_what_an_editor_wrote_during_it(tmp_path: Path) -> None:
    path = tmp_path.resolve() / "a.yaml"
    path.write_bytes(b"a: 1")
    reload = reload_once_then(ge.GraphError("refused"), lambda: path.write_bytes(b"a: 9"))
    with pytest.raises(ge.GraphError):
        ValueEdits(reload).write(Change(path, b"a: 1", b"a: 2", ""))
    assert path.read_bytes() == b"a: 9"


def test_a_file_in_a_folder_that_became_a_link_is_not_written(tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    (tmp_path / "other/a.yaml").write_bytes(b"a: 1")
    (tmp_path / "folder").symlink_to("other")
    change = Change(tmp_path.resolve() / "folder/a.yaml", b"a: 1", b"a: 2", "")
    with pytest.raises(StateError, match="has changed meanwhile"):
        ValueEdits(lambda: None).write(change)
    assert (tmp_path / "other/a.yaml").read_bytes() == b"a: 1"


def test_the_present_value_of_an_array_is_written_as_a_list(run: Runner, folder: Path) -> None:
    run.command("set", address="List.value", value=[4.0, 5.0, 6.0])
    run.command("save", address="List.value")
    assert "value: [4.0, 5.0, 6.0]" in (folder / "outer.yaml").read_text(encoding="utf-8")


def test_an_editor_outside_loses_nothing(run: Runner, folder: Path) -> None:
    path = folder / "outer.yaml"
    run.command("save", address="Limit.value", value=0.2)
    outside = path.read_text(encoding="utf-8") + "# a remark of an editor\n"
    path.write_text(outside, encoding="utf-8")
    with pytest.raises(UsageError, match="has changed since the session read it: reload it first"):
        run.command("save", address="Limit.value", value=0.3)
    with pytest.raises(StateError, match="has changed meanwhile"):
        run.command("undo")
    assert path.read_text(encoding="utf-8") == outside
    run.command("reload")
    run.command("save", address="Limit.value", value=0.3)
    assert path.read_text(encoding="utf-8") == outside.replace("0.2", "0.3")


def test_a_value_of_the_option_set_cannot_be_saved(folder: Path) -> None:
    scene = ge.load(folder / "outer.yaml", set={"Limit.value": 0.9})
    with start_runner(scene, RunOptions(edit=True)) as run, pytest.raises(UsageError, match="has its value from --set"):
        run.command("save", address="Limit.value", value=0.2)


def test_a_file_that_ships_is_not_changed_and_a_copy_is_offered(tmp_path: Path) -> None:
    shutil.copy(ROOT / "scenes/dd100_flat.yaml", tmp_path / "scene.yaml")
    with (
        start_runner(ge.load(tmp_path / "scene.yaml", rays="mujoco"), RunOptions(edit=True)) as run,
        pytest.raises(UsageError, match=r"cmd_vel\.yaml ships with graphengine and is not changed\n  copy it into"),
    ):
        run.command("save", address="DiffController.maxLinearSpeed", value=0.2)


def test_links_and_files_outside_of_the_folder_are_not_changed(tmp_path: Path) -> None:
    inside, outside = tmp_path / "project", tmp_path / "other"
    inside.mkdir()
    outside.mkdir()
    (outside / "inner.yaml").write_text(INNER, encoding="utf-8")
    (inside / "outer.yaml").write_text(OUTER, encoding="utf-8")
    (inside / "inner.yaml").symlink_to(outside / "inner.yaml")
    scene = ge.load(inside / "outer.yaml", allow=[outside])
    with (
        start_runner(scene, RunOptions(edit=True)) as run,
        pytest.raises(UsageError, match="outside of the scene's folder"),
    ):
        run.command("save", address="Left/Own.value", value=0.3)
    assert (outside / "inner.yaml").read_text(encoding="utf-8") == INNER
    assert (inside / "inner.yaml").is_symlink()


def test_a_link_that_replaces_the_file_before_the_write_is_not_followed(
    run: Runner, folder: Path, tmp_path: Path
) -> None:
    secret = tmp_path / "secret.txt"
    secret.write_text("secret", encoding="utf-8")
    run.command("save", address="Limit.value", value=0.2)
    os.remove(folder / "outer.yaml")
    (folder / "outer.yaml").symlink_to(secret)
    with pytest.raises(StateError, match="has changed meanwhile"):
        run.command("undo")
    assert secret.read_text(encoding="utf-8") == "secret"


@pytest.mark.parametrize("seed", range(5))
def test_a_hundred_random_changes_of_shipped_graphs_are_undone_to_the_byte(seed: int, tmp_path: Path) -> None:
    """Together 500 values and positions on copies of all shipped graphs; after each, the file is legal and its comments stand."""
    rng = random.Random(seed)
    shutil.copytree(ROOT / "graphs", tmp_path / "graphs")
    shutil.copytree(ROOT / "scenes/robots", tmp_path / "robots")
    shutil.copytree(ROOT / "graphs", tmp_path / "robots/graphs")
    scene = (
        (ROOT / "scenes/dd100_flat.yaml")
        .read_text("utf-8")
        .replace("worlds/flat_grid.xml", "scenes/worlds/flat_grid.xml")
    )
    (tmp_path / "scene.yaml").write_text(scene, "utf-8")
    before = texts(tmp_path)
    with start_runner(ge.load(tmp_path / "scene.yaml", rays="mujoco"), RunOptions(edit=True)) as run:
        done, refused = 0, list[str]()
        for _ in range(100):
            graph = rng.choice(run.session.graphs)
            instance = rng.choice([one for one in graph.executor.graph.instances if not one.part_of])
            if rng.random() < 0.3:
                words: dict[str, Any] = {
                    "graph": graph.name,
                    "node": instance.id,
                    "position": [rng.uniform(-500, 500), 10.0],
                }
                kind = "place"
            else:
                ports = [port for port in instance.cls.fields.values() if port.side == "inputs" and not port.is_exec]
                numbers = [
                    port
                    for port in ports
                    if isinstance(getattr(graph.executor.nodes[instance.index], port.field), float)
                ]
                if not numbers:
                    continue
                kind, port = "save", rng.choice(numbers)
                words = {
                    "address": f"{graph.name}/{instance.id}.{port.name}",
                    "value": round(rng.uniform(0.01, 0.9), 3),
                }
            try:
                run.command(kind, **words)
            except UsageError as error:
                refused.append(str(error))
                continue
            done += 1
            for name, data in texts(tmp_path).items():
                if data != before[name]:
                    findings = Findings()
                    assert parse(data.decode(), name, findings) is not None
                    assert not findings.errors
                    assert data.count(b"#") == before[name].count(b"#")
        assert done > 20
        assert all(re.search("wired|engine|expected|scene|outside of its subgraphs", text) for text in refused)
        for _ in range(done):
            run.command("undo")
        with pytest.raises(StateError, match="there is no change to undo"):
            run.command("undo")
    assert texts(tmp_path) == before
