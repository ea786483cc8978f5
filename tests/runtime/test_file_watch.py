"""Files that are saved in the ways of editors, that go, and that come back as something else."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import pytest

from graphengine.format import document
from graphengine.format.diagnostics import CheckError
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.runtime.command_queue import CommandQueue
from graphengine.runtime.file_watch import FileWatch
from graphengine.scene import build
from tests.waiting import PATIENCE

GRAPH = """graph: g
nodes:
  Tick: OnPlaybackTick
  Counter: omni.graph.action.Counter
connections:
  - Tick.tick -> Counter.execIn
"""
PART = """graph: part
inputs: {execIn: Inner.execIn}
nodes:
  Inner: omni.graph.action.Counter
"""
WITH_PART = GRAPH.replace("  Counter: omni.graph.action.Counter\n", "  Counter: {subgraph: part.yaml}\n")
MORE = GRAPH.replace("connections", "  More: {type: ConstantDouble}\nconnections")


class Watched:
    """A session of a graph file that is watched; it is paused, and does what it is asked for."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.reports: list[Future[Any]] = []
        network = LiveNetwork(lambda _: MemoryTransport(), 0, lambda complaint: None)
        self.session = build.start(build.load(path), network)
        self.session.queue = CommandQueue()
        self.session.step(5)
        self.watch = FileWatch(self.session.reloader, self.session.queue, self.reports.append)

    def await_report(self, wanted: Callable[[Future[Any]], bool] = lambda report: True) -> Future[Any]:
        """The next report that is as wanted."""
        deadline = time.monotonic() + PATIENCE
        while time.monotonic() < deadline:
            assert self.session.queue is not None
            self.session.queue.wait(0.01)
            self.session.queue.serve(self.session)
            while self.reports:
                if wanted(report := self.reports.pop(0)):
                    return report
        raise AssertionError("no report came")

    def await_change(self) -> Any:
        return self.await_report(lambda report: report.exception() is None).result()

    def await_error(self) -> CheckError:
        error = self.await_report(lambda report: report.exception() is not None).exception()
        assert isinstance(error, CheckError)
        return error

    @property
    def count(self) -> int:
        counter: Any = self.session.graphs[0].executor.node("Counter")
        return int(counter.count)


@pytest.fixture
def watched(tmp_path: Path) -> Iterator[Watched]:
    path = tmp_path / "g.yaml"
    path.write_text(GRAPH, encoding="utf-8")
    made = Watched(path)
    yield made
    made.watch.close()
    made.session.close()


def in_place(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


def by_rename(path: Path, text: str) -> None:
    (path.parent / ".g.yaml.swp").write_text(text, encoding="utf-8")
    (path.parent / ".g.yaml.swp").replace(path)


def with_backup(path: Path, text: str) -> None:
    path.rename(path.with_suffix(".yaml~"))
    path.write_text(text, encoding="utf-8")


def in_pieces(path: Path, text: str) -> None:
    with path.open("w", encoding="utf-8") as file:
        for piece in (text[:30], text[30:]):
            file.write(piece)
            file.flush()
            os.fsync(file.fileno())


@pytest.mark.parametrize("save", [in_place, by_rename, with_backup, in_pieces])
def test_a_change_is_detected_with_every_way_of_saving(watched: Watched, save: Callable[[Path, str], None]) -> None:
    save(watched.path, MORE)
    done = watched.await_report(lambda report: report.exception() is None and report.result()["changed"]).result()
    assert (done["changed"], done["kept"], done["nodes"]) == (("g",), 2, 3)
    assert (watched.session.state, watched.count) == ("paused", 5)


def test_two_saves_cause_two_reloads(watched: Watched) -> None:
    for text in (MORE, GRAPH):
        in_place(watched.path, text)
        assert watched.await_change()["changed"] == ("g",)


def test_a_deleted_file_is_an_error_until_it_exists_again(watched: Watched) -> None:
    watched.path.unlink()
    assert "cannot read" in str(watched.await_error())
    assert watched.session.findings[0].startswith(f"{watched.path}:1:1: error G101")
    watched.session.step()
    assert watched.count == 6
    in_place(watched.path, GRAPH)
    assert watched.await_change()["mended"]
    assert watched.session.findings == ()


def test_a_pipe_instead_of_a_file_does_not_block(watched: Watched) -> None:
    watched.path.unlink()
    os.mkfifo(watched.path)
    while "regular" not in str(watched.await_error()):
        pass
    watched.path.unlink()
    in_place(watched.path, GRAPH)
    assert watched.await_change()["mended"]


def test_a_huge_file_is_not_read_completely(watched: Watched) -> None:
    with watched.path.open("a", encoding="utf-8") as file:
        file.truncate(100 * document.MAX_BYTES)
    assert "is larger than 8 MB" in str(watched.await_error())


def test_a_missing_file_is_watched_from_its_creation_on(watched: Watched) -> None:
    in_place(watched.path, WITH_PART)
    assert "no file 'part.yaml'" in str(watched.await_error())
    part = watched.path.parent / "part.yaml"
    in_place(part, PART)
    done = watched.await_change()
    assert (done["mended"], done["changed"]) == (True, ("g",))
    in_place(part, PART + "  Other: {type: ConstantDouble}\n")
    assert watched.await_change()["files"] == [str(part)]
    part.unlink()
    assert "no file 'part.yaml'" in str(watched.await_error())


def test_a_save_between_loading_and_watching_is_detected(tmp_path: Path) -> None:
    path = tmp_path / "g.yaml"
    path.write_text(GRAPH, encoding="utf-8")
    loaded = build.load(path)
    in_place(path, MORE)
    with build.start(loaded, LiveNetwork(lambda _: MemoryTransport(), 0, lambda complaint: None)) as session:
        assert session.reload().changed == ("g",)


def test_the_watch_can_be_closed_while_it_waits_for_an_idle_session(watched: Watched) -> None:
    in_place(watched.path, MORE)
    watched.watch.close()
    watched.watch.close()
