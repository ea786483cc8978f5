"""The page of a recording: viewers move through it, and cannot change it."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("viser", reason="the extra view is not installed")

from graphengine.api.recording_view import Playback, open_recording_page, turn
from graphengine.format.errors import UsageError
from graphengine.recording.player import RecordingPlayer
from graphengine.runtime.commands import parse
from graphengine.view.feed import Feed
from tests.recording.harness import DRIVE, at, playing, record
from tests.view.harness import Viewer

TICKS = 200
LIMIT = "DiffController.inputs:maxLinearSpeed"


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A drive with a command after its hundredth tick."""
    made = tmp_path_factory.mktemp("recording") / "out.mcap"
    limit = parse("set", {"address": "DiffController.maxLinearSpeed", "value": 0.25})
    record(made, TICKS, "dd100_flat", commands=DRIVE, before=at(101, lambda run: limit.apply(run.session)))
    return made


@pytest.fixture
def player(path: Path) -> Iterator[RecordingPlayer]:
    with playing(path) as made:
        yield made


def looked_at(player: RecordingPlayer, play: Callable[[Viewer], Any]) -> Any:
    """Serve the page of a recording while a viewer plays; the result of the play."""
    playback = Playback(player)
    with closing(open_recording_page(playback, "127.0.0.1", 0)) as feed, ThreadPoolExecutor(1) as pool:

        def play_and_leave() -> Any:
            viewer = Viewer(feed.wait())
            with viewer.socket:
                return play(viewer)

        played = pool.submit(play_and_leave)
        while not played.done():
            turn(playback, feed)
        return played.result()


def shown(frame: Any) -> Any:
    """What a frame has of the recording."""
    return frame["facts"]["recording"]


def test_viewers_seek_and_see_the_values_of_that_time(player: RecordingPlayer) -> None:
    def play(viewer: Viewer) -> Any:
        viewer.ask(ask="look", graph="dd100/cmd_vel")
        viewer.until(lambda frame: shown(frame)["complete"])
        found = []
        for tick in (150, 50):
            viewer.ask(ask="playback", do="seek", tick=tick)
            frame = viewer.until(lambda frame: shown(frame)["position"] == tick and frame["values"])  # noqa: B023
            found.append((frame["facts"]["tick"], frame["values"]["dd100/cmd_vel"][LIMIT]))
        place = viewer.wait("graph")["nodes"]["DiffController"]["place"]
        return found, shown(viewer.frame)["verdict"], place

    (late, early), verdict, place = looked_at(player, play)
    assert late == (150, 0.25)
    assert early[0] == 50
    assert early[1] > 0.25
    assert verdict == "identical"
    assert place == "shipped/graphs/dd100/cmd_vel.yaml:15:3"


def test_marks_come_to_viewers_who_come_later_too(player: RecordingPlayer) -> None:
    player.build()

    def play(viewer: Viewer) -> Any:
        viewer.until(lambda frame: viewer.marks)
        return viewer.marks

    (mark,) = looked_at(player, play)
    assert (mark["tick"], mark["kind"]) == (101, "command")
    assert mark["text"].startswith("set ")


def test_it_plays(player: RecordingPlayer) -> None:
    def play(viewer: Viewer) -> Any:
        viewer.ask(ask="playback", do="speed", factor=8)
        viewer.ask(ask="playback", do="play")
        frame = viewer.until(lambda frame: shown(frame)["position"] == TICKS and not shown(frame)["playing"])
        return frame["facts"]["state"]

    assert looked_at(player, play) == "paused"


def test_what_happened_cannot_be_changed(player: RecordingPlayer) -> None:
    def play(viewer: Viewer) -> Any:
        told = [viewer.command("reset"), viewer.command("set", address=LIMIT, value=1.0)]
        viewer.ask(ask="playback", id=7, do="rewind")
        return [*told, viewer.answer(7)], viewer.stage["drives"]

    told, drives = looked_at(player, play)
    assert [answer["error"] for answer in told[:2]] == ["this page shows a recording, which cannot be changed"] * 2
    assert "play, pause, seek, step, speed" in told[2]["error"]
    assert drives == {}


def test_nodes_that_the_replay_in_the_background_runs_do_not_light_up(
    player: RecordingPlayer, monkeypatch: pytest.MonkeyPatch
) -> None:
    build_tick = player._build_tick

    def build_slowly() -> None:  # one tick between two frames
        time.sleep(0.06)
        build_tick()

    monkeypatch.setattr(player, "_build_tick", build_slowly)

    def play(viewer: Viewer) -> Any:
        viewer.ask(ask="look", graph="dd100/cmd_vel")
        viewer.until(lambda frame: frame["values"])
        return [viewer.next_frame() for _ in range(3)]

    frames = looked_at(player, play)
    assert not shown(frames[-1])["complete"]
    assert [frame["nodes"]["dd100/cmd_vel"].get("DiffController", [0])[0] for frame in frames] == [0, 0, 0]


def test_the_end_of_the_pages_process_ends_the_look(player: RecordingPlayer) -> None:
    playback = Playback(player)

    def play_on(feed: Feed) -> None:
        while True:
            turn(playback, feed)

    with closing(open_recording_page(playback, "127.0.0.1", 0)) as feed:
        feed.page._process.kill()
        with pytest.raises(UsageError, match="the process that serves the page has ended"):
            play_on(feed)
