"""Chromium that shows the page of a session."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any

import pytest

import graphengine as ge
from tests.waiting import eventually

sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")

CHROMIUM = shutil.which("chromium")
FLAGS = ["--no-sandbox", "--no-first-run", "--disable-background-networking", "--disable-component-update"]
FLAGS += ["--disable-quic", "--disable-sync"]
# WebGL without a GPU. A flag that names a GL backend would also paint the rest of the page with it, which takes twice as long.
FLAGS += ["--enable-unsafe-swiftshader"]

FEW_FRAMES = """
  window.requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), 200);
  window.cancelAnimationFrame = clearTimeout;
"""
"""Script that limits the page to 5 frames per second, because without a GPU each frame of the 3D part takes the processors."""

needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium: apt-get install chromium")


@contextmanager
def browser(url: str) -> Iterator[Any]:
    """The page in Chromium; what its scripts raise fails the test."""
    raised: list[str] = []
    with sync_api.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = chromium.new_context(viewport={"width": 1280, "height": 800}).new_page()
        page.set_default_timeout(60_000)
        page.add_init_script(FEW_FRAMES)
        page.on("pageerror", lambda error: raised.append(str(error)))
        page.goto(url)
        yield page
        chromium.close()
    assert raised == []


def seen(sim: ge.Session, look: Callable[[Any], Any]) -> Any:
    """Run a session in real time while a browser looks at it; what the look found."""
    url = sim.view()

    def open_and_look() -> Any:
        with browser(url) as page:
            return look(page)

    with ThreadPoolExecutor(1) as pool:
        looked = pool.submit(open_and_look)
        # One run: a pause that comes between two runs is undone by the second.
        sim.run(math.inf, rate=1.0, until=lambda _: looked.done())
        return looked.result()


def seconds(page: Any) -> float:
    """The time that the page shows."""
    return float(page.inner_text("#time").removesuffix(" s"))


def until(page: Any, condition: str) -> None:
    """Wait until an expression of the page holds."""
    assert eventually(lambda: page.evaluate(f"() => Boolean({condition})"), lambda: page.wait_for_timeout(50)), (
        condition
    )
