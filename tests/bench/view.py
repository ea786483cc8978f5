"""What a page costs the ticks of a run, and its own process.

`python -m tests.bench.view [SECONDS]` runs dd100_warehouse over memory as fast as it can, by turns without a page, with one that
nobody looks at, and with one viewer who looks at a graph, 20 times a second; then twenty robots with lidars in real time. It
prints ratios of the thread's processor time, and the share of a core that the page's process takes; nothing is asserted.
"""

from __future__ import annotations

import json
import os
import statistics
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

import graphengine as ge
from tests.view.harness import socket_of

ROUNDS = 15
FLEET = """scene: fleet
world: worlds/full_warehouse.xml
robots:
  dd100: {use: robots/dd100.yaml, count: 20, per_row: 5, spacing: [1.2, 1.2], position: [-25.0, -12.6, 0.025]}
"""


@contextmanager
def looking(url: str) -> Iterator[None]:
    """A viewer that reads all it gets, in the 3D part and in the feed, and looks at the last graph."""
    sockets = [
        connect(socket_of(url, "/feed"), max_size=None),
        connect(socket_of(url, "/3d"), max_size=None, subprotocols=["viser-v1.1.1"]),  # type: ignore[list-item]
    ]

    def read(number: int) -> None:
        try:
            for text in sockets[number]:
                if number == 0 and isinstance(text, str) and text.startswith('{"stage"'):
                    graph = json.loads(text)["stage"]["graphs"][-1]["name"]
                    sockets[0].send(json.dumps({"ask": "look", "graph": graph}))
        except ConnectionClosed:
            pass

    threads = [threading.Thread(target=read, args=(number,), daemon=True) for number in range(2)]
    for thread in threads:
        thread.start()
    yield
    for socket in sockets:
        socket.close()
    for thread in threads:
        thread.join()


def microseconds(sim: ge.Session, seconds: float) -> float:
    """Processor time of this thread for a tick."""
    ticks, cpu = sim.tick, time.thread_time()
    sim.run(seconds)
    return (time.thread_time() - cpu) / (sim.tick - ticks) * 1e6


def ticks(seconds: float) -> None:
    """The three ways by turns."""
    scene = ge.load("dd100_warehouse")
    with scene.session() as plain, scene.session() as served, scene.session() as seen:
        served.view()
        with looking(seen.view()):
            for sim in (plain, served, seen):
                sim.robots["dd100"].subscribe("sim_lidar/scan", keep=1)
                sim.run(2.0)
            rounds = [[microseconds(sim, seconds) for sim in (plain, served, seen)] for _ in range(ROUNDS)]
    print(f"a tick without a page {statistics.median(one[0] for one in rounds):.0f} us")
    for number, what in ((1, "a page that nobody looks at (bar 1.03)"), (2, "one viewer (bar 1.10)")):
        ratios = sorted(one[number] / one[0] for one in rounds)
        print(f"  {what}: x{statistics.median(ratios):.3f} ({ratios[1]:.3f} to {ratios[-2]:.3f})")


def fleet(seconds: float) -> None:
    """Twenty robots with lidars, seen by one viewer."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "fleet.yaml"
        path.write_text(FLEET, encoding="utf-8")
        with ge.load(path).session() as sim, looking(sim.view()):
            for name in sim.robots:
                sim.robots[name].publish("cmd_vel", {"linear": {"x": 0.2}, "angular": {"z": 0.5}}, every=0.1)
            feed = sim._runner.feed
            assert feed is not None
            sim.run(2.0, rate=1.0)
            before, wall, ticks = _used(feed.page.process_id), time.perf_counter(), sim.tick
            sim.run(seconds, rate=1.0)
            elapsed = time.perf_counter() - wall
            share = (_used(feed.page.process_id) - before) / elapsed
            factor = (sim.tick - ticks) / 60 / elapsed
    print(
        f"20 robots with lidars, x{factor:.2f} of real time: the page's process takes {share:.2f} of a core (bar 0.5)"
    )


def _used(process: int) -> float:
    """Processor time of a process, s."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


if __name__ == "__main__":
    duration = float(sys.argv[1]) if sys.argv[1:] else 5.0
    ticks(duration)
    fleet(2 * duration)
