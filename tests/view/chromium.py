"""Chromium that shows the page of a session."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any, Literal

import pytest

import graphengine as ge
from tests.waiting import eventually

sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")

CHROMIUM = shutil.which("chromium")
FLAGS = ["--no-sandbox", "--no-first-run", "--disable-background-networking", "--disable-component-update"]
FLAGS += ["--disable-quic", "--disable-sync"]
# WebGL without a GPU. A flag that names a GL backend would also paint the rest of the page with it, which takes twice as long.
FLAGS += ["--enable-unsafe-swiftshader"]

needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium: apt-get install chromium")


@contextmanager
def browser(
    url: str, *, size: tuple[int, int] = (1280, 800), scheme: Literal["light", "dark"] = "light"
) -> Iterator[Any]:
    """The page in Chromium; what its scripts raise fails the test."""
    raised: list[str] = []
    with sync_api.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = chromium.new_page(viewport={"width": size[0], "height": size[1]}, color_scheme=scheme)
        page.set_default_timeout(60_000)
        page.on("pageerror", lambda error: raised.append(str(error)))
        page.goto(url)
        yield page
        chromium.close()
    assert raised == []


def seen(sim: ge.Session, look: Callable[[Any], Any], **options: Any) -> Any:
    """Run a session in real time while a browser looks at it; what the look found. Options are those of `browser`."""
    url = sim.view()

    def open_and_look() -> Any:
        with browser(url, **options) as page:
            return look(page)

    with ThreadPoolExecutor(1) as pool:
        looked = pool.submit(open_and_look)
        while not looked.done():
            sim.run(5.0, rate=1.0, until=lambda _: looked.done())
        return looked.result()


def seconds(page: Any) -> float:
    """The time that the page shows."""
    return float(page.inner_text("#time").removesuffix(" s"))


def until(page: Any, condition: str) -> None:
    """Wait until an expression of the page holds."""
    assert eventually(lambda: page.evaluate(f"() => Boolean({condition})"), lambda: page.wait_for_timeout(50)), (
        condition
    )
