"""The page in a real browser: what is seen changes with the run, and what is clicked and pressed reaches it."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any

import pytest

import graphengine as ge
from graphengine.testing import session
from tests.waiting import eventually

pytest.importorskip("viser", reason="the extra view is not installed")
sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")

CHROMIUM = shutil.which("chromium")
FLAGS = ["--no-sandbox", "--no-first-run", "--disable-background-networking", "--disable-component-update"]
FLAGS += [
    "--disable-quic",
    "--disable-sync",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
]

pytestmark = [
    pytest.mark.xdist_group("view"),
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium: apt-get install chromium"),
]


@contextmanager
def browser(url: str) -> Iterator[Any]:
    """The page in Chromium; what its scripts raise fails the test."""
    raised: list[str] = []
    with sync_api.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = chromium.new_page(viewport={"width": 1280, "height": 800})
        page.set_default_timeout(60_000)
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


def test_the_page_shows_the_run_and_controls_it() -> None:
    def look(page: Any) -> dict[str, Any]:
        found: dict[str, Any] = {}
        until(page, "document.querySelector('[data-node=\"DiffController\"].ran')")
        page.click('[data-node="DiffController"]')
        row = 'tr[data-port="DiffController.inputs:maxLinearSpeed"] input'
        until(page, f"document.querySelector('{row}')?.value !== ''")
        found["shown"] = float(page.input_value(row))
        found["place"] = page.inner_text("#side")

        page.click("#wheel")
        page.keyboard.down("w")
        page.click('[data-node="SubscribeTwist"]')
        velocity = 'tr[data-port="SubscribeTwist.outputs:linearVelocity"] .value'
        until(page, f"document.querySelector('{velocity}').textContent.startsWith('(0.5')")
        page.keyboard.up("w")
        until(page, f"document.querySelector('{velocity}').textContent.startsWith('(0,')")

        page.click("#pause")
        until(page, "document.getElementById('state').textContent === 'paused'")
        found["held"] = seconds(page), seconds(page)
        page.click('[data-node="DiffController"]')
        page.fill(row, "0.25")
        page.press(row, "Enter")
        until(page, f"document.querySelector('{row}').value === '0.25'")
        page.fill(row, '"fast"')
        page.press(row, "Enter")
        until(page, "document.getElementById('message').textContent !== ''")
        found["message"] = page.inner_text("#message")
        page.click("#play")
        until(page, "document.getElementById('state').textContent === 'playing'")
        wide = "Math.max(0, ...[...document.querySelectorAll('canvas')].map((canvas) => canvas.width))"
        assert eventually(lambda: page.frames[1].evaluate(wide) > 300, lambda: page.wait_for_timeout(50))
        return found

    with session("dd100_flat") as sim:
        limit = sim.value("DiffController.maxLinearSpeed")
        found = seen(sim, look)
        assert found["shown"] == limit
        assert re.search(r"cmd_vel\.yaml:\d+:3", found["place"])
        assert found["held"][0] == found["held"][1]
        assert sim.value("DiffController.maxLinearSpeed") == 0.25
        assert "expected a number" in found["message"]
        assert sim.robots["dd100"].pose.position[0] > 0.05


def test_layers_are_switched_in_the_panel_of_the_3d_part() -> None:
    with session("dd100_warehouse") as sim:

        def shown() -> frozenset[str]:
            feed = sim._runner.feed
            assert feed is not None
            return feed._viewers.layers

        def look(page: Any) -> None:
            assert eventually(lambda: len(page.frames) > 1, lambda: page.wait_for_timeout(50))
            world = page.frames[1]
            world.get_by_text("Layers").first.click()
            for title in ("Cameras", "Frames", "Contacts", "Trails", "Map"):
                world.get_by_label(title, exact=True).check(force=True)
            every = {"lidar", "cameras", "frames", "contacts", "trails", "map"}
            assert eventually(lambda: shown() == every, lambda: page.wait_for_timeout(50))
            world.get_by_label("Lidar", exact=True).uncheck(force=True)
            assert eventually(lambda: shown() == every - {"lidar"}, lambda: page.wait_for_timeout(50))
            assert eventually(lambda: world.get_by_label("Selected").input_value() == "dd100")
            page.wait_for_timeout(1000)

        seen(sim, look)


def test_without_the_token_there_is_no_page() -> None:
    with session("dd100_flat") as sim:
        base = sim.view().partition("?")[0]
        with browser(base) as page:
            assert "open the address that graphrun printed" in page.inner_text("body")
