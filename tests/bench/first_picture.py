"""How long a browser takes to the first picture of a page.

`python -m tests.bench.first_picture [SCENE [ROUNDS]]` opens the page of dd100_warehouse, or of another scene, in a new Chromium
without a GPU, five times. It prints the seconds from the navigation to

- the canvas of the 3D part,
- the first frame that shows the world, from any side and without the textures that arrive later,
- the first frame in which robot and world are drawn as they stay: at most 3 % of the pixels of the whole picture and of its
  middle, where the robot is, differ from the picture once nothing changes any more,

and the processor time that browser and page took until then, which other programs on the machine change less. A script reads the
pixels of the canvas at the end of each animation frame, which waits until they are drawn; a screenshot would also paint the rest
of the page, and takes a software renderer about a second. Nothing is asserted.
"""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import sync_playwright

import graphengine as ge
from tests.view.chromium import CHROMIUM, FLAGS

ROUNDS = 5
QUIET = 3.0
"""Wall time without a changed pixel after which the picture is complete, s."""
WATCH = """
if (self !== top) {
  const { getContext } = HTMLCanvasElement.prototype, next = self.requestAnimationFrame.bind(self);
  const frames = (top.frames3d = []);
  let gl = null;
  HTMLCanvasElement.prototype.getContext = function (...options) {
    const made = getContext.apply(this, options);
    if (options[0] === "webgl2" && this.isConnected) {
      gl = made;
      top.canvas3d = performance.timeOrigin + performance.now();
    }
    return made;
  };
  self.requestAnimationFrame = (act) => next((time) => {
    act(time);
    if (gl) look();
  });
  const STEP = 4; // of the pixels, one in this many in each direction is kept
  function look() {
    const { drawingBufferWidth: width, drawingBufferHeight: height } = gl;
    const pixels = new Uint32Array(width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(pixels.buffer));
    const columns = Math.floor(width / STEP), rows = Math.floor(height / STEP), kept = new Uint32Array(columns * rows);
    for (let i = 0; i < kept.length; i += 1) kept[i] = pixels[STEP * (Math.floor(i / columns) * width + (i % columns))];
    if (kept.some(Boolean)) frames.push({ at: performance.timeOrigin + performance.now(), columns, rows, kept });
  }
  const near = (a, b) => [0, 8, 16].every((shift) => Math.abs(((a >> shift) & 255) - ((b >> shift) & 255)) <= 24);
  const isMiddle = (at, size) => Math.abs(at - size / 2) < size / 12;
  function same(one, other) { // the share of equal pixels, in the whole picture or in its middle, whichever is less
    let all = 0, middle = 0, inMiddle = 0;
    for (let i = 0; i < one.kept.length; i += 1) {
      const equal = near(one.kept[i], other.kept[i]);
      all += equal;
      if (!isMiddle(i % one.columns, one.columns) || !isMiddle(Math.floor(i / one.columns), one.rows)) continue;
      inMiddle += 1;
      middle += equal;
    }
    return Math.min(all / one.kept.length, middle / inMiddle);
  }
  const colours = (one) => new Set(one.kept.map((pixel) => pixel & 0xf8f8f8)).size;
  top.found3d = () => {
    const last = frames.at(-1), world = frames.find((one) => colours(one) > 40);
    if (!last || !world) return null;
    const whole = frames.find((one) => one.kept.length === last.kept.length && same(one, last) > 0.97);
    const now = performance.timeOrigin + performance.now();
    return { canvas: top.canvas3d, world: world.at, whole: whole.at, since: now - whole.at };
  };
}
"""
"""Script for the 3D part's frame."""


class Usage(threading.Thread):
    """Records the processor time of this process' descendants ten times a second, until `end` is set."""

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self.end = threading.Event()
        self._record: list[tuple[float, float]] = []

    def run(self) -> None:
        """Record until the end."""
        while not self.end.wait(0.05):
            self._record.append((time.time(), _used_below(os.getpid())))

    def between(self, begun: float, ended: float) -> float:
        """Return the processor time between two wall times, s."""
        at, used = np.array(self._record).T
        return float(np.interp(ended, at, used) - np.interp(begun, at, used))


def _used_below(process: int) -> float:
    """Return the processor time of all descendants of a process, s."""
    parents: dict[int, tuple[int, int]] = {}
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text().rpartition(")")[2].split()
        except OSError:  # it has ended
            continue
        parents[int(path.parent.name)] = int(fields[1]), int(fields[11]) + int(fields[12])
    used, above = 0, {process}
    while above:
        below = {one for one, (parent, _) in parents.items() if parent in above}
        used, above = used + sum(parents[one][1] for one in below), below
    return used / os.sysconf("SC_CLK_TCK")


def opened(url: str) -> Mapping[str, float]:
    """Return the seconds to the canvas, to the world and to the whole picture, and the processor time until then."""
    usage = Usage()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page: Any = browser.new_page(viewport={"width": 1280, "height": 800})
        page.add_init_script(WATCH)
        usage.start()
        time.sleep(0.2)
        begun = time.time()
        page.goto(url, wait_until="commit")
        found: Any = None
        while found is None or found["since"] < 1e3 * QUIET:
            page.wait_for_timeout(1000)
            found = page.evaluate("() => self.found3d?.() ?? null")
        usage.end.set()
        browser.close()
    times = {name: found[name] / 1e3 - begun for name in ("canvas", "world", "whole")}
    return {**times, "used": usage.between(begun, begun + times["whole"])}


def main() -> None:
    """Open the page, and print what it took."""
    scene, rounds = sys.argv[1] if sys.argv[1:] else "dd100_warehouse", int(sys.argv[2]) if sys.argv[2:] else ROUNDS
    with ge.load(scene).session() as sim, ThreadPoolExecutor(1) as pool:
        url = sim.view()
        for _ in range(rounds):
            busy = os.getloadavg()[0]
            done = pool.submit(opened, url)
            while not done.done():
                sim.run(5.0, rate=1.0, until=lambda _: done.done())  # noqa: B023
            print(
                "canvas {canvas:.2f} s, world {world:.2f} s, robot and world as they stay {whole:.2f} s (bar 3), "
                "processor time {used:.2f} s".format(**done.result()),
                f"(load before {busy:.1f})",
            )


if __name__ == "__main__":
    main()
