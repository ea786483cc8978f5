"""Take a picture of the web page of a run in Chromium, light or dark.

python -m tests.pictures.page light docs/pictures/page_light.png
python -m tests.pictures.page dark docs/pictures/page_dark.png
"""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import graphengine as ge
from tests.view.chromium import browser, until

SIZE = {"width": 1440, "height": 900}
DRIVE = {"linear": {"x": 0.15}, "angular": {"z": 0.1}}
BEFORE, RATE = 0.2, 0.25
"""Simulation time before the page is opened, s, and rate afterwards: without a GPU, the browser takes most of the processors."""
SETTLED = 8000
"""Time for the 3D part to draw the world, ms."""


def draw(scheme: str, path: Path) -> None:
    """Write the picture: a robot that drives in the warehouse, its scan, and the values of the graph that drives it."""

    def look(url: str) -> bytes:
        with browser("about:blank") as page:
            page.set_viewport_size(SIZE)
            page.emulate_media(color_scheme=scheme)
            page.goto(url)
            until(page, "document.querySelector('[data-node=\"DiffController\"].ran')")
            page.click('[data-node="DiffController"]')
            page.wait_for_timeout(SETTLED)
            taken: bytes = page.screenshot()
            return taken

    with ge.load("dd100_warehouse", rays="mujoco").session() as sim, ThreadPoolExecutor(1) as pool:
        sim.publish("/dd100_0000/cmd_vel", DRIVE, every=0.1)
        sim.run(BEFORE)
        looked: Any = pool.submit(look, sim.view())
        while not looked.done():
            sim.run(5.0, rate=RATE, until=lambda _: looked.done())
        path.write_bytes(looked.result())


if __name__ == "__main__":
    draw(sys.argv[1], Path(sys.argv[2]))
