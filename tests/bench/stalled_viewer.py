"""What a viewer costs whose tab stops reading.

`python -m tests.bench.stalled_viewer [SECONDS]` runs dd100_warehouse over memory with the page open, in real time and then as
fast as it can. After 10 s in which a viewer reads and looks at a graph and at a topic, the viewer stops reading for 60 s, or as
many as given, without closing its sockets. Printed are the memory of the run's process and of the page's process before and
after, the largest in between, and the processor time of a tick with the viewer that reads and with the one that does not; nothing
is asserted. The page disconnects a viewer that answers no ping for 20 s.
"""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from pathlib import Path
from typing import Any

from websockets.sync.client import ClientConnection, connect

import graphengine as ge
from tests.view.harness import socket_of

READ = 10.0
"""Wall time for which the viewer reads, s."""
LIMIT = 50.0
"""Bar for the growth of both processes, MB."""


class Viewer(threading.Thread):
    """Reads feed and 3D part until `stalled` is set; then its sockets stay open, and the system's buffers fill."""

    def __init__(self, url: str) -> None:
        super().__init__(daemon=True)
        options: Any = {"max_size": None, "max_queue": 1}
        options["ping_interval"] = None  # only the page ends the connection
        self.feed: ClientConnection = connect(socket_of(url, "/feed"), **options)
        options["subprotocols"] = ["viser-v1.1.1"]
        self.scene: ClientConnection = connect(socket_of(url, "/3d"), **options)
        self.stalled = threading.Event()

    def run(self) -> None:
        """Read."""
        while not self.stalled.is_set():
            for socket in (self.feed, self.scene):
                text = self._read(socket)
                if isinstance(text, str) and text.startswith('{"stage"'):
                    graph = json.loads(text)["stage"]["graphs"][-1]["name"]
                    self.feed.send(json.dumps({"ask": "look", "graph": graph}))
                    self.feed.send(json.dumps({"ask": "topics", "open": True, "topic": "/dd100_0000/sim_lidar/scan"}))

    @staticmethod
    def _read(socket: ClientConnection) -> str | bytes:
        try:
            return socket.recv(timeout=0.02)
        except TimeoutError:
            return b""


def megabytes(process: int) -> float:
    """Return the resident memory of a process, MB."""
    line = next(one for one in Path(f"/proc/{process}/status").read_text().splitlines() if one.startswith("VmRSS"))
    return int(line.split()[1]) * 1024 / 1e6


def played(sim: ge.Session, seconds: float, rate: float | None, processes: list[int]) -> tuple[float, list[float]]:
    """Run for a wall time; return the thread's processor time per tick, us, and the largest memory of each process, MB."""
    end, largest = time.monotonic() + seconds, [0.0 for _ in processes]
    tick, cpu = sim.tick, time.thread_time()
    while time.monotonic() < end:
        pause = min(end, time.monotonic() + 1.0)
        sim.run(1e9, rate=rate, until=lambda _: time.monotonic() > pause)  # noqa: B023
        largest = [max(was, megabytes(process)) for was, process in zip(largest, processes, strict=True)]
    return (time.thread_time() - cpu) / (sim.tick - tick) * 1e6, largest


def measured(rate: float | None, seconds: float) -> None:
    """Print what a stalled viewer costs at a rate; None is as fast as possible."""
    with ge.load("dd100_warehouse").session() as sim:
        url = sim.view()
        feed = sim._runner.feed
        assert feed is not None
        processes = [os.getpid(), feed.page.process_id]
        played(sim, 5.0, rate, processes)
        viewer = Viewer(url)
        viewer.start()
        reading, _ = played(sim, READ, rate, processes)
        before = [megabytes(process) for process in processes]
        viewer.stalled.set()
        viewer.join()
        stalled, largest = played(sim, seconds, rate, processes)
        after = [megabytes(process) for process in processes]
    pace = "as fast as possible" if rate is None else "in real time"
    grown = sum(largest) - sum(before)
    print(f"{pace}, not reading for {seconds:.0f} s: memory grows by {grown:.1f} MB at most (bar {LIMIT:.0f})")
    for name, *one in zip(("run", "page"), before, largest, after, strict=True):
        print("  {}: {:.1f} MB before, {:.1f} MB at most, {:.1f} MB after".format(name, *one))
    print(f"  a tick takes {stalled:.0f} us; {reading:.0f} us with a viewer that reads")


if __name__ == "__main__":
    for pace in (1.0, None):
        measured(pace, float(sys.argv[1]) if sys.argv[1:] else 60.0)
