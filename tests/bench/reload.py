"""Time from saving a file of a watched run to its effect, in milliseconds of wall time.

`python -m tests.bench.reload [SCENE]` copies the graphs and scenes that ship and runs one (dd100_warehouse) in real time as
`graphrun run --watch` does. It saves in turns: a graph with another limit, a graph with an error, the mended graph, a scene with
another name of the robot. Nothing is asserted.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import Any

from graphengine.api.run_options import RunOptions
from graphengine.api.runner import Runner
from graphengine.runtime.file_watch import FileWatch
from graphengine.runtime.session_core import SessionCore
from graphengine.scene import build
from graphengine.scene.loaded_scene import Options

ROOT = Path(__file__).parents[2]
ROUNDS = 10
PAUSE = 0.4
"""Seconds between an effect and the next save."""
KINDS = ("graph", "error", "mended", "world")


@dataclass
class Saves:
    """Saves files one after the other, each once the one before has taken effect."""

    graph: Path
    scene: Path
    took: dict[str, list[float]] = field(default_factory=lambda: {kind: [] for kind in KINDS})
    number: int = 0
    saved: float = 0.0
    effect: float = 0.0

    def report(self, done: Future[Any]) -> None:
        """Take the time of an effect."""
        self.effect = time.perf_counter()
        kind = KINDS[(self.number - 1) % len(KINDS)]
        failed = isinstance(done.exception(), Exception)
        assert failed == (kind == "error"), done.exception()
        self.took[kind].append(self.effect - self.saved)
        self.saved = 0.0

    def on_tick(self, session: SessionCore) -> bool:
        """Save the next file if it is time to; whether there are more."""
        if not self.saved and time.perf_counter() - self.effect > PAUSE:
            if self.number == ROUNDS * len(KINDS):
                return False
            round_, kind = divmod(self.number, len(KINDS))
            self.number += 1
            SAVES[KINDS[kind]](self, round_)
            self.saved = time.perf_counter()
        return True

    def save_graph(self, number: int, misspelt: str = "") -> None:
        text = (ROOT / "graphs/dd100/cmd_vel.yaml").read_text(encoding="utf-8")
        limit = f"maxLinearSpeed{misspelt}: {0.1 + 0.01 * number}"
        self.graph.write_text(text.replace("maxLinearSpeed: 1.3", limit), encoding="utf-8")

    def save_error(self, number: int) -> None:
        self.save_graph(number, "x")

    def save_mended(self, number: int) -> None:
        self.save_graph(number + 100)

    def save_world(self, number: int) -> None:
        text = (ROOT / "scenes" / self.scene.name).read_text(encoding="utf-8")
        self.scene.write_text(text.replace("  dd100:\n", f"  dd100_{number}:\n", 1), encoding="utf-8")


SAVES: dict[str, Callable[[Saves, int], None]] = {
    "graph": Saves.save_graph,
    "error": Saves.save_error,
    "mended": Saves.save_mended,
    "world": Saves.save_world,
}


def main() -> None:
    """Print what each kind of save took."""
    name = sys.argv[1] if len(sys.argv) > 1 else "dd100_warehouse"
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder)
        for part in ("graphs", "scenes"):
            shutil.copytree(ROOT / part, library / part)
        saves = Saves(library / "graphs/dd100/cmd_vel.yaml", library / f"scenes/{name}.yaml")
        with Runner(build.load(saves.scene, Options(shipped=library)), RunOptions()) as runner:
            saves.effect = time.perf_counter()
            with FileWatch(runner.session.reloader, runner.queue, saves.report):
                runner.run(None, 1.0, saves.on_tick)
    for kind, seconds in saves.took.items():
        worst = 1e3 * max(seconds)
        print(f"{name}, {kind}: median {1e3 * median(seconds):.0f} ms, worst {worst:.0f} ms of {len(seconds)}")


if __name__ == "__main__":
    main()
