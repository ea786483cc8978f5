"""The samples of a run for its HTML file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from graphengine.api.recording_page import sample_replay
from graphengine.format.spec import RobotUse
from graphengine.runtime.entity_commands import Spawn
from graphengine.testing import session
from graphengine.view.html.html_file import LogEntry, Plot, robot_plots, write_html
from graphengine.view.html.payload import Payload
from graphengine.view.html.scene_data import SceneData
from graphengine.view.html.trace import SceneTrace
from graphengine.view.scene.shape_surfaces import simplified
from tests.recording.harness import Run, playing, put, record
from tests.view.html.worlds import SCENE, WORLD


def shapes(folder: Path) -> Path:
    put(folder / "world.xml", WORLD)
    return put(folder / "scene.yaml", SCENE)


def test_poses_are_sampled_thirty_times_a_second_and_scans_five_times(tmp_path: Path) -> None:
    path = tmp_path / "out.mcap"
    record(path, 61, shapes(tmp_path))
    with playing(path) as player:
        trace = sample_replay(player)
        last = player.session.services.world.poses().astype(np.float32)
    (stage,) = trace.stages
    assert stage.ticks == [*range(0, 61, 2), 61]
    assert np.array_equal(stage.poses[-1], last)
    ticks = stage.lidars[0].ticks
    assert min(np.diff(ticks)) >= 0.2 * 60
    assert len(ticks) == 5


def test_an_added_robot_begins_another_part(tmp_path: Path) -> None:
    path, use = tmp_path / "out.mcap", RobotUse(use="robots/dd100.yaml", position=(0.0, 5.0, 0.025), namespace="late")

    def before(tick: int, run: Run) -> None:
        if tick == 20:
            Spawn(name="late", use=use).apply(run.session)

    record(path, 30, shapes(tmp_path), before=before)
    with playing(path) as player:
        trace = sample_replay(player)
    assert [list(stage.robots) for stage in trace.stages] == [["dd100"], ["dd100", "late"]]
    assert [stage.ticks[0] for stage in trace.stages] == [0, 20]
    assert [plot.name for plot in robot_plots(trace)][2:] == ["late: speed", "late: turn rate"]
    data = SceneData(Payload())
    _, first = data.stage(trace.stages[0], trace), len(data.surfaces)
    data.stage(trace.stages[1], trace)
    assert len(data.surfaces) == first  # the second robot has the surfaces of the first


def test_bodies_that_stand_still_have_no_samples(tmp_path: Path) -> None:
    with session(shapes(tmp_path)) as sim:
        trace = SceneTrace(sim._runner.session)
        for tick in range(31):
            sim.step()
            trace.sample(tick)
    stored = SceneData(Payload()).stage(trace.stages[0], trace)
    names = trace.stages[0].bodies.names
    assert stored["moving"]["count"] < len(names)
    assert stored["poses"]["count"] == stored["moving"]["count"] * 7 * len(trace.stages[0].ticks)


def test_a_live_session_is_written_without_a_recording(tmp_path: Path) -> None:
    path = tmp_path / "new" / "run.html"
    with session(shapes(tmp_path)) as sim:
        trace = SceneTrace(sim._runner.session)
        trace.sample(0)
        write_html(
            trace,
            path,
            title="one tick",
            plots=[Plot("a", [0.0], [float("inf")])],
            marks=[LogEntry(1, "error", "b")],
        )
    assert path.read_text(encoding="utf-8").startswith("<!doctype html>")
    assert [file.name for file in path.parent.iterdir()] == ["run.html"]


def test_a_minute_of_the_warehouse_stays_below_four_megabytes(tmp_path: Path) -> None:
    sizes = []
    for seconds in (1, 6):
        path = tmp_path / f"{seconds}.mcap"
        record(path, 60 * seconds, "dd100_warehouse", commands={1: [(0.5, 0.4)], 180: [(0.5, -0.4)]})
        with playing(path) as player:
            write_html(sample_replay(player), tmp_path / "out.html", title="warehouse")
        sizes.append((tmp_path / "out.html").stat().st_size)
    assert sizes[0] + (sizes[1] - sizes[0]) / 5 * 59 < 4_000_000


def test_a_failed_write_keeps_the_older_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = put(tmp_path / "run.html", "older")
    with session(shapes(tmp_path)) as sim:
        trace = SceneTrace(sim._runner.session)
        trace.sample(0)

        def full(*arguments: object) -> None:
            raise OSError(28, "No space left on device")

        monkeypatch.setattr("os.fsync", full)
        with pytest.raises(OSError, match=f"{path}"):
            write_html(trace, path, title="full")
    assert path.read_text(encoding="utf-8") == "older"
    assert not list(tmp_path.glob("*.part"))


def test_a_large_surface_keeps_its_extent() -> None:
    sphere = trimesh.creation.icosphere(subdivisions=6, radius=2.0)  # 81 920 triangles
    vertices, faces = simplified(np.asarray(sphere.vertices, np.float32), np.asarray(sphere.faces, np.int32), 20_000)
    assert 5_000 < len(faces) <= 20_000
    assert np.linalg.norm(vertices, axis=1) == pytest.approx(2.0, abs=1e-5)
    assert np.ptp(vertices, axis=0) == pytest.approx(4.0, abs=0.1)
    assert faces.max() < len(vertices)
