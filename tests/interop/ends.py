"""The two ends of a cell of the interop matrix: a transport of this project, and a node of rclpy in another process."""

from __future__ import annotations

import contextlib
import json
import os
import queue
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from graphengine.format.files import installed_packages
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.messages.endpoints import QoS
from graphengine.messages.messages import decode, encode
from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions, Transport, Writer
from graphengine.ros.transports.select import open_transport
from tests.interop.samples import TYPES, Tally, fill, paced

ROOT = Path(__file__).resolve().parents[2]
PATIENCE = 20.0
"""Seconds that one end waits for the other."""
_ANSWER = 120.0
"""Seconds within which a peer carries out a command."""


class CellError(Exception):
    """A cell does not reach its bar; the text says what happened."""


class UnreachableError(CellError):
    """Services of the peer are not found, and the other end was told what to do."""


def seconds_until(condition: Callable[[], object], what: str, patience: float = PATIENCE) -> float:
    """Return the seconds until something holds.

    Raises:
        CellError: it does not hold in time.
    """
    begun = time.monotonic()
    while not condition():
        if time.monotonic() - begun > patience:
            raise CellError(f"this did not happen within {patience:g} s: {what}")
        time.sleep(0.002)
    return time.monotonic() - begun


class Peer:
    """A process of `ros_peer.py`; calls of unknown methods are its commands."""

    def __init__(self, domain: int, *options: str) -> None:
        command = [sys.executable, "-m", "tests.interop.ros_peer", *options]
        self.process = subprocess.Popen(
            command, cwd=ROOT, env=environment(domain), stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self._lines: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._reading = threading.Thread(target=self._read, daemon=True)
        self._reading.start()
        self._answer()

    def __getattr__(self, command: str) -> Callable[..., dict[str, Any]]:
        def carry_out(**arguments: Any) -> dict[str, Any]:
            assert self.process.stdin is not None
            self.process.stdin.write(f"{json.dumps({'do': command, **arguments})}\n")
            self.process.stdin.flush()
            return self._answer()

        return carry_out

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self._lines.put(line)
        self._lines.put("")

    def _answer(self) -> dict[str, Any]:
        try:
            line = self._lines.get(timeout=_ANSWER)
        except queue.Empty:
            raise CellError(f"the ROS 2 node does not answer within {_ANSWER:g} s") from None
        if not line:
            raise CellError("the ROS 2 node has ended")
        answer: dict[str, Any] = json.loads(line)
        return answer

    def kill(self) -> None:
        """End the process as `kill -9` does."""
        self.process.kill()
        self.end()

    def end(self) -> None:
        """Let the process end by itself, else kill it."""
        with contextlib.suppress(BrokenPipeError):
            assert self.process.stdin is not None
            self.process.stdin.close()
        try:
            self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self._reading.join(PATIENCE)


class Ours:
    """A transport of this project in this process."""

    def __init__(self, kind: str, domain: int, name: str = "interop_ours") -> None:
        self.definitions: Definitions = DEFINITIONS.extended(installed=installed_packages())
        joined = JoinOptions(Domain(domain, "LOCALHOST"), name, environ=os.environ, definitions=self.definitions)
        self.transport: Transport = open_transport(kind, joined)

    def listen(self, topic: str, kind: str, qos: QoS, size: int = 0) -> Tally:
        """Open a reader."""
        tally, name = Tally(kind, size), TYPES[kind]
        self.transport.reader(topic, name, qos, lambda data: tally.add(decode(data, name, self.definitions)))
        return tally

    def send(self, writer: Writer, kind: str, count: int, rate: float, size: int = 0, first: int = 0) -> float:
        """Send numbered messages at a rate; return the seconds that it took."""
        data = np.full(size, 7, np.uint8)

        def one(number: int) -> None:
            message = self.definitions.initial(TYPES[kind])
            fill(message, kind, number, lambda values: np.array(values, np.float64), self.definitions.initial, data)
            writer.write(encode(message, self.definitions))

        return paced(count, rate, one, first)


def environment(domain: int) -> dict[str, str]:
    """Variables for a process in a domain of this machine."""
    return {
        **os.environ,
        "ROS_DOMAIN_ID": str(domain),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "PYTHONPATH": f"{ROOT}{os.pathsep}{os.environ.get('PYTHONPATH', '')}",
    }


class Run:
    """`graphrun run` in a process, and what it prints on stderr."""

    def __init__(self, kind: str, domain: int, *arguments: str) -> None:
        command = [sys.executable, "-m", "graphengine.cli", "run", *arguments, "--transport", kind]
        self.process = subprocess.Popen(
            command, cwd=ROOT, env=environment(domain), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
        )
        self._lines: list[str] = []
        self._reading = threading.Thread(target=self._read, daemon=True)
        self._reading.start()

    def _read(self) -> None:
        assert self.process.stderr is not None
        self._lines.extend(iter(self.process.stderr.readline, ""))

    @property
    def said(self) -> str:
        """What it printed."""
        return "".join(self._lines)

    def end(self) -> None:
        """End it as Ctrl-C does."""
        self.process.terminate()
        self.process.wait(60.0)
        self._reading.join(PATIENCE)


class Cell:
    """Opens the ends of one cell, and closes them.

    Args:
        kind: our transport.
        domain: ROS 2 domain of the cell.
        folder: folder for files.
    """

    def __init__(self, kind: str, domain: int, folder: Path, closing: contextlib.ExitStack) -> None:
        self.kind, self.domain, self.folder, self._closing = kind, domain, folder, closing

    def ours(self, name: str = "interop_ours") -> Ours:
        """Open a node of ours."""
        made = Ours(self.kind, self.domain, name)
        self._closing.callback(made.transport.close)
        return made

    def peer(self, *options: str) -> Peer:
        """Start a node of rclpy."""
        made = Peer(self.domain, *options)
        self._closing.callback(made.end)
        return made

    def run(self, *arguments: str) -> Run:
        """Start `graphrun run`."""
        made = Run(self.kind, self.domain, *arguments)
        self._closing.callback(made.end)
        return made


@contextlib.contextmanager
def opened(kind: str, domain: int, folder: Path) -> Iterator[Cell]:
    """Yield a cell, and close what it opened."""
    with contextlib.ExitStack() as closing:
        yield Cell(kind, domain, folder, closing)
