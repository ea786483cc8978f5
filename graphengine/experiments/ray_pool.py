"""Makes runs on a Ray cluster: Ray chooses the machine, moves the files there and repeats a run whose machine was lost.

Each process of Ray has a worker of graphengine as its child, so limits and crashes have the same rows as on one machine.
"""

from __future__ import annotations

import atexit
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from graphengine.api.scene_files import UnpackedScene
from graphengine.experiments.result_rows import Row, start_row
from graphengine.experiments.runs import Bundle, Run
from graphengine.experiments.worker_process import RunSettings
from graphengine.experiments.workers import LOOK, Limits, Worker
from graphengine.format.distribution import install_command
from graphengine.format.errors import UsageError

RETRIES = 3
"""Number of times that Ray makes a run again whose process or machine was lost."""
AHEAD = 2
"""Number of runs that wait for each processor of the cluster."""

_unpacked: dict[str, tuple[Any, UnpackedScene | None]] = {}
"""In a process of Ray: the folders with the files of scenes, by the digest of the files, each with the place of the scene."""
_workers: dict[tuple[RunSettings, Limits], Worker] = {}
"""In a process of Ray: its worker."""


class RayPool:
    """Makes runs on a Ray cluster.

    Args:
        address: address of a running cluster, or `auto`; empty starts one on this machine.
        settings: settings common to all runs.
        limits: limits of each run.

    Raises:
        UsageError: Ray is not installed, or the cluster does not answer.
    """

    def __init__(self, address: str, settings: RunSettings, limits: Limits) -> None:
        try:
            import ray
        except ImportError:
            raise UsageError(f"--workers ray needs Ray; install it with: {install_command('ray')}") from None
        self._ray: Any = ray
        self._settings, self._limits = settings, limits
        self._own = not ray.is_initialized()
        if self._own:
            try:
                ray.init(
                    address=address or "local", include_dashboard=False, log_to_driver=False, logging_level="error"
                )
            except (ConnectionError, ValueError, RuntimeError) as error:
                raise UsageError(f"--workers ray:{address}: {error}") from None
        self._make = ray.remote(max_retries=RETRIES, num_cpus=1)(make_here)

    def rows(self, runs: Iterable[Run]) -> Iterator[Row]:
        """Execute runs; yield the row of each run when the run ends."""
        bundles: dict[int, Any] = {}
        given = self._ray.put((self._settings, self._limits))
        waiting, going = iter(runs), dict[Any, Run]()
        while True:
            ahead = AHEAD * max(1, int(self._ray.cluster_resources().get("CPU", 1)))
            while len(going) < ahead and (run := next(waiting, None)) is not None:
                key = id(run.bundle)
                bundles[key] = bundles.get(key) or self._ray.put(run.bundle)
                going[self._make.remote(bundles[key], run.case, run.number, given)] = run
            if not going:
                return
            for done in self._ray.wait(list(going), num_returns=1)[0]:
                yield self._result(done, going.pop(done))

    def _result(self, done: Any, run: Run) -> Row:
        try:
            row: Row = self._ray.get(done)
        except self._ray.exceptions.RayError as error:
            return start_row(run) | {"reason": f"Ray lost the run {RETRIES + 1} times: {type(error).__name__}"}
        return row

    def close(self) -> None:
        """Leave the cluster, and end it if it was started for the runs."""
        if self._own:
            self._ray.shutdown()


def make_here(bundle: Bundle, case: Any, number: int, given: tuple[RunSettings, Limits]) -> Row:
    """Make a run in a process of Ray and return its row."""
    if given not in _workers:
        _workers[given] = Worker(*given)
        atexit.register(_workers[given].close)
    worker = _workers[given]
    if bundle.inputs not in _unpacked:
        made = tempfile.TemporaryDirectory(prefix="graphengine-")
        place = bundle.files.unpack(Path(made.name)) if bundle.files is not None else None
        _unpacked[bundle.inputs] = made, place
    folder, place = _unpacked[bundle.inputs]
    worker.begin(Run(bundle, case, number), place)
    while (row := worker.look()) is None:
        worker.pipe.poll(LOOK)
    files, unpacked = bundle.files, Path(folder.name).resolve()
    return row | ({"reason": files.original(row["reason"], unpacked)} if files is not None else {})
