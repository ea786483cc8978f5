"""How long a browser takes to the first picture of a page.

`python -m tests.bench.first_picture [SCENE]` opens the page of dd100_warehouse, or of another scene, in Chromium with drawing by
software, three times, and prints the seconds from the printed address to the canvas of the 3D part and to a picture on it. Most
of the time is the browser's, which has to draw without a GPU on as many cores as there are; nothing is asserted.
"""

from __future__ import annotations

import io
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from PIL import Image
from playwright.sync_api import sync_playwright

import graphengine as ge
from tests.view.chromium import CHROMIUM, FLAGS

ROUNDS = 3
PART = {"x": 50, "y": 250, "width": 500, "height": 150}
"""Of the page, where the world is seen."""
COLOURS = 200
"""In that part, from which on it holds a picture."""


def opened(url: str) -> tuple[float, float]:
    """Seconds to the canvas, and to the picture."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page: Any = browser.new_page(viewport={"width": 1280, "height": 800})
        begun = time.perf_counter()
        page.goto(url, wait_until="commit")
        page.frame_locator("iframe").locator("canvas").first.wait_for(timeout=60_000)
        canvas = time.perf_counter() - begun
        while True:
            part = Image.open(io.BytesIO(page.screenshot(clip=PART))).convert("RGB")
            if len(part.getcolors(1 << 20) or ()) > COLOURS:
                break
        picture = time.perf_counter() - begun
        browser.close()
    return canvas, picture


def main() -> None:
    """Open the page, and print what it took."""
    with ge.load(sys.argv[1] if sys.argv[1:] else "dd100_warehouse").session() as sim, ThreadPoolExecutor(1) as pool:
        url = sim.view()
        for _ in range(ROUNDS):
            done = pool.submit(opened, url)
            while not done.done():
                sim.run(5.0, rate=1.0, until=lambda _: done.done())  # noqa: B023
            canvas, picture = done.result()
            print(f"canvas after {canvas:.2f} s, picture after {picture:.2f} s (bar 3)")


if __name__ == "__main__":
    main()
