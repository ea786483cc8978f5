"""What a picture costs, and what drawing does to the pace of ticks, in the full warehouse.

`python tests/bench/camera.py [SECONDS]` prints milliseconds a picture by size and content, and how late ticks of 60 Hz are
without and with a camera that draws beside them; nothing is asserted. Mesa draws with as many threads as there are cores;
`LP_NUM_THREADS=1` before the command keeps it to one.
"""

from __future__ import annotations

import statistics
import sys
import time
from pathlib import Path

from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files, find_file
from graphengine.format.scene_spec import SceneSpec
from graphengine.format.spec_reader import read
from graphengine.physics.loading import load_world
from graphengine.physics.sensors.camera import PinholeCamera
from graphengine.physics.simulation import Simulation

PRIM = "/dd100/base_link/chassis_link/sim_camera/RSD455/Camera_OmniVision_OV9782_Color"
SIZES = ((640, 480), (1280, 720))
ROUNDS = 15


def main(seconds: float) -> None:
    """Run and print."""
    simulation = load("dd100_warehouse")
    print(f"{simulation.model.ngeom} geoms; medians of {ROUNDS} pictures")
    for size in SIZES:
        camera = camera_of(simulation, size)
        camera.picture()
        capture, colours, segments = (measure(camera, what) for what in ("capture", "colours", "segments"))
        print(
            f"{size[0]} x {size[1]}: {1e6 * capture:.0f} us to capture in the tick; drawn in its thread: "
            f"{1e3 * colours:.1f} ms with depths, {1e3 * segments:.1f} ms with segments too"
        )
    print(f"lateness of ticks of 60 Hz over {seconds:g} s: median, 99 %, greatest, ms")
    for title, asked in (("no camera", None), ("640 x 480 at 30 Hz", SIZES[0]), ("1280 x 720 at 30 Hz", SIZES[1])):
        print(f"  {title}: {pace(simulation, asked, seconds)}")
    simulation.close()


def load(name: str) -> Simulation:
    """A scene that ships, without its graphs."""
    path = find_file(name)
    findings = Findings()
    scene = read(SceneSpec, path, findings)
    loaded = load_world(scene, Files.of(path, (), Path.cwd()), findings) if scene is not None else None
    findings.raise_errors()
    assert loaded is not None
    return loaded.simulation


def camera_of(simulation: Simulation, size: tuple[int, int]) -> PinholeCamera:
    """The colour camera, with pictures of a size."""
    return simulation.device(PinholeCamera, simulation.stage.find(PRIM), size=size)


def measure(camera: PinholeCamera, what: str) -> float:
    """Seconds of one part of the work."""
    times = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        if what == "capture":
            shown = camera._expose(segmentation=False)
            times.append(time.perf_counter() - start)
            shown.result()
        else:
            camera.picture(segmentation=what == "segments")
            times.append(time.perf_counter() - start)
    return statistics.median(times)


def pace(simulation: Simulation, size: tuple[int, int] | None, seconds: float) -> str:
    """Run in real time and tell how late ticks ended their waiting."""
    camera = camera_of(simulation, size) if size is not None else None
    simulation.reset()
    simulation.realtime = True
    period, late, delivered = 1 / 60, [], 0
    deadline = time.perf_counter()
    for tick in range(1, round(seconds / period) + 1):
        for _ in range(simulation.substeps):
            simulation.step()
        simulation.begin_tick(tick)
        if camera is not None:
            camera.request()
            delivered += camera.delivered() is not None
        deadline += period
        time.sleep(max(0.0, deadline - time.perf_counter()))
        late.append(time.perf_counter() - deadline)
    simulation.realtime = False
    late.sort()
    figures = ", ".join(f"{1e3 * late[min(int(share * len(late)), len(late) - 1)]:.2f}" for share in (0.5, 0.99, 1.0))
    dropped = sum(simulation.dropped_pictures.values())
    return figures + (f"; {delivered} pictures delivered, {dropped} dropped" if camera is not None else "")


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 10.0)
