"""Take a picture of the web page of a run in Chromium, light or dark.

python -m tests.pictures.page light docs/pictures/page_light.png
python -m tests.pictures.page dark docs/pictures/page_dark.png
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import graphengine as ge
from tests.view.chromium import seen, until

SIZE = {"width": 1440, "height": 900}
SETTLED = 6000
"""Time for the 3D part to draw the world without a GPU, ms."""


def draw(scheme: str, path: Path) -> None:
    """Write the picture: a robot that drives in the warehouse, its scan, and the values of the graph that drives it."""

    def look(page: Any) -> None:
        page.set_viewport_size(SIZE)
        page.emulate_media(color_scheme=scheme)
        page.reload()  # the 3D part takes its colours when it is loaded
        until(page, "document.querySelector('[data-node=\"DiffController\"].ran')")
        world = page.frame_locator("#world")
        print(
            page.frames[1].evaluate(
                "() => [...document.querySelectorAll('input[type=checkbox]')].map((x)=>x.closest('div').parentElement.parentElement.outerHTML).join('\\n----\\n')"
            )[:3000]
        )
        page.click('[data-node="DiffController"]')
        until(page, "document.querySelector('canvas')")
        page.wait_for_timeout(SETTLED)
        page.screenshot(path=path)

    with ge.load("dd100_warehouse", rays="mujoco").session() as sim:
        sim.publish("/dd100_0000/cmd_vel", {"linear": {"x": 0.3}, "angular": {"z": 0.4}}, every=0.1)
        seen(sim, look)


if __name__ == "__main__":
    draw(sys.argv[1], Path(sys.argv[2]))
