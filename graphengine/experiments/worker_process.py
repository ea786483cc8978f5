"""The program of a worker: makes runs that it gets from a pipe, one after the other, and sends back their rows."""

from __future__ import annotations

import os
import queue
import signal
import sys
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from graphengine.api.scene import Scene
from graphengine.api.scene_files import UnpackedScene
from graphengine.experiments.case_run import CaseOptions, run_case
from graphengine.experiments.programs import children, signal_groups
from graphengine.experiments.result_rows import Row, row_of, start_row
from graphengine.experiments.runs import Bundle, Run
from graphengine.experiments.scenario import Scenario

KEPT = 8
"""Number of loaded scenes that a worker keeps: a scene with other values of inputs is another one."""
GRACE = 5.0
"""Time that a run gets to end when its worker is to end, s."""


@dataclass(frozen=True, slots=True)
class RunSettings:
    """Settings common to all runs of a worker.

    Attributes:
        programs: whether scenarios may start programs.
        scripts: whether graphs may run the Python code of their ScriptNodes.
        digest_all: whether the digest of the output covers the messages of all topics, or only of topics with subscribers.
        make: function that makes a run and returns its row; None: `make_run`.
    """

    programs: bool = False
    scripts: bool = False
    digest_all: bool = False
    make: Callable[[Run, RunSettings, Scenes], Row] | None = None


class Scenes:
    """The scenes that a worker has loaded, the newest last."""

    def __init__(self) -> None:
        self.places: dict[Path, UnpackedScene | None] = {}
        """Unpacked scenes by the file of the scenario; None reads the files from where the scenario has them."""
        self._kept: dict[str, Scene] = {}

    def load(self, scenario: Scenario, settings: Mapping[str, Any], *, allow_scripts: bool) -> Scene:
        """Return the scene of a scenario, as `Scenario.load`; it is loaded if none is kept for these values of inputs."""
        key = repr((scenario.path, settings))
        if key not in self._kept:
            scene = self._loaded(scenario, settings, allow_scripts)
            while len(self._kept) >= KEPT:
                del self._kept[next(iter(self._kept))]
            self._kept[key] = scene
        return self._kept[key]

    def _loaded(self, scenario: Scenario, settings: Mapping[str, Any], allow_scripts: bool) -> Scene:
        place = self.places.get(scenario.path)
        if place is None:
            return scenario.load(settings, allow_scripts=allow_scripts)
        return place.load(settings, allow_scripts=allow_scripts)


def make_run(run: Run, settings: RunSettings, scenes: Scenes) -> Row:
    """Make a run and return its row; an exception of graphengine itself is an error of the run."""
    options = CaseOptions(
        programs=settings.programs,
        scripts=settings.scripts,
        digest=settings.digest_all,
        load=scenes.load,
        log=lambda severity, node, text: None,
    )
    begin = time.perf_counter()
    try:
        result = run_case(run.bundle.scenario, run.case, options, run=run.number)
    except Exception as error:
        return start_row(run) | {"reason": f"internal error: {type(error).__name__}: {error}"}
    return row_of(run, result, time.perf_counter() - begin)


def main() -> None:
    """Make runs until the driver closes the pipe, whose number is the argument of the program."""
    pipe = Connection(int(sys.argv[1]))
    sys.path[:] = pipe.recv()
    orders: queue.SimpleQueue[Any] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(pipe, orders), daemon=True).start()
    scenes, bundles = Scenes(), dict[str, Bundle]()
    settings: RunSettings = orders.get()
    try:
        while True:
            key, new, case, number = orders.get()
            if new is not None:
                bundles[key], scenes.places[new[0].scenario.path] = new
            pipe.send((settings.make or make_run)(Run(bundles[key], case, number), settings, scenes))
    except KeyboardInterrupt:
        pass


def _listen(pipe: Connection, orders: queue.SimpleQueue[Any]) -> None:
    """Receive orders; when the driver has closed the pipe or is gone, end the run and the process."""
    try:
        while True:
            orders.put(pipe.recv())
    except (EOFError, OSError):
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(GRACE)
        signal_groups(children(os.getpid()), signal.SIGKILL)  # programs that `Programs.close` has not ended yet
        os._exit(1)


if __name__ == "__main__":
    main()
