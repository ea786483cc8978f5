"""A scenario for tests: a ball falls 0.5 s, and a script does harm where the matrix says so."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

G = 9.81
STEP = 0.01

WORLD = (
    """<mujoco><worldbody><body name="ball" pos="0 0 2"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>"""
)
SCENE = "{scene: hall, world: world.xml, physics: {tick_rate: 100, substeps: 1}, graphs: {own: {use: graph.yaml}}}"
GRAPH = """
graph: own
nodes:
  Tick: OnPlaybackTick
  Time: ReadSimulationTime
  Noise: {type: omni.graph.nodes.RandomGaussian, inputs: {mean: 0.0, stdev: 0.001}}
  Script:
    type: omni.graph.scriptnode.ScriptNode
    inputs:
      attributes: ["inputs:harm double", "inputs:noise double", "outputs:number double"]
      inputs:harm: 0
      script: |
        import os, time
        def compute(db):
            if db.inputs.harm == 1: os.abort()
            while db.inputs.harm == 2: time.sleep(0.01)
            if db.inputs.harm == 3: db.per_instance_state.hog = b"x" * 10**9
            db.outputs.number = db.inputs.harm + db.inputs.noise
  Clock: {type: PublishClock, inputs: {topicName: clock}}
connections:
  - Tick.tick -> Noise.execIn
  - Noise.execOut -> Script.execIn
  - Noise.random -> Script.inputs:noise
  - Tick.tick -> Clock.execIn
  - Time.simulationTime -> Clock.timeStamp
"""
SCENARIO = """
scenario: falls
scene: scene.yaml
matrix: {MATRIX}
expect:
  - always: port("Script.number") < 4.5
  - within: 1s
    reach: pose("ball").position[2] < 1.5
  - rate: {topic: /clock, at_least: 99, over: 0.1}
metrics:
  speed: {min: 'velocity("ball").linear[2]'}
  number: {mean: port("Script.number")}
  low: {time_to: 'pose("ball").position[2] < 1.5'}
stop: {after: 0.5s}
"""
PASSES, ABORTS, HANGS, HOGS, FAILS = 0, 1, 2, 3, 5
"""Values of `Script.harm`."""


def write_scenario(folder: Path, seeds: Sequence[int], harms: Sequence[int], more: str = "") -> Path:
    """Write the files of the scenario to a folder; `more` are further lines of the scenario."""
    matrix = f"seed: {list(seeds)}, Script.harm: {list(harms)}"
    texts = {"world.xml": WORLD, "scene.yaml": SCENE, "graph.yaml": GRAPH}
    texts["falls.scenario.yaml"] = SCENARIO.replace("MATRIX", matrix) + more
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder / "falls.scenario.yaml"


def start(folder: Path, *arguments: str) -> subprocess.Popen[str]:
    """Start `graphrun test` in a folder."""
    environ = {name: value for name, value in os.environ.items() if name != "RAY_ADDRESS"}
    return subprocess.Popen(
        [sys.executable, "-m", "graphengine.cli", "test", "--allow-scripts", *arguments],
        cwd=folder,
        env=environ,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def finish(process: subprocess.Popen[str], code: int) -> str:
    """Wait for the end of a process and return its output, after its errors."""
    output, errors = process.communicate(timeout=240)
    assert process.returncode == code, errors
    return errors + output


def run(folder: Path, *arguments: str, code: int = 0) -> str:
    """Run `graphrun test` in a folder and return its output, after its errors."""
    return finish(start(folder, *arguments), code)


def rows(path: Path) -> list[dict[str, Any]]:
    """Return the rows of a results file in the order of their cases."""
    found = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    return sorted(found, key=lambda row: (row["seed"], row["parameters"]["Script.harm"]))


def without_wall(path: Path) -> list[str]:
    """Return the lines of a results file without wall times, sorted."""
    found = map(json.loads, path.read_text(encoding="utf-8").splitlines())
    return sorted(json.dumps({**row, "wall": None}) for row in found)


def processes(begin: bytes) -> list[int]:
    """Return the numbers of the processes whose command line begins so; NUL is between its words."""
    found = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        with contextlib.suppress(OSError):  # it has ended
            if path.read_bytes().startswith(begin):
                found.append(int(path.parent.name))
    return found
