"""The page in a real browser: what is seen changes with the run, and what is clicked and pressed reaches it."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pytest

import graphengine as ge
from graphengine.api.recording_view import Playback, open_recording_page, turn
from graphengine.recording.player import RecordingPlayer
from graphengine.testing import session
from tests.recording.harness import playing
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


def play(player: RecordingPlayer, look: Callable[[Any], Any]) -> Any:
    """Serve the page of a recording while a browser looks at it; what the look found."""
    playback = Playback(player)
    with closing(open_recording_page(playback, "127.0.0.1", 0)) as feed, ThreadPoolExecutor(1) as pool:

        def open_and_look() -> Any:
            with browser(feed.url) as page:
                return look(page)

        looked = pool.submit(open_and_look)
        while not looked.done():
            turn(playback, feed)
        return looked.result()


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


def test_without_the_token_there_is_no_page() -> None:
    with session("dd100_flat") as sim:
        base = sim.view().partition("?")[0]
        with browser(base) as page:
            assert "open the address that graphrun printed" in page.inner_text("body")


def test_a_recording_is_seen_at_any_time(tmp_path: Path) -> None:
    path = tmp_path / "out.mcap"
    with session("dd100_flat", record=path) as sim:
        drive = sim.robots["dd100"].publish("cmd_vel", {"linear": {"x": 0.4}, "angular": {"z": 0.3}}, every=0.1)
        sim.run(30.0)
        then = sim.value("dd100/joint_states/ComputeOdom.position")
        drive.close()
        sim.push("dd100", impulse=(0.0, 30.0, 0.0))
        sim.run(2.0)

    def look(page: Any) -> dict[str, Any]:
        found: dict[str, Any] = {}
        until(page, "document.getElementById('verdict').textContent === 'identical'")
        page.click("text=dd100/joint_states")
        page.click('[data-node="ComputeOdom"]')
        slide = "const slider = document.getElementById('slider'); slider.value = 1800; slider.dispatchEvent(new Event('input'))"
        page.evaluate(f"() => {{ {slide} }}")  # at once, as frames move the slider too
        until(page, "document.getElementById('place').textContent === '30.00 / 32.00 s'")
        value = 'tr[data-port="ComputeOdom.outputs:position"] .value'
        place = "(" + ", ".join(f"{part:.4g}" for part in then) + ")"
        until(page, f"document.querySelector('{value}').textContent === '{place}'")
        found["marks"] = page.eval_on_selector_all("#marks button", "all => all.map((mark) => mark.title)")

        page.click("#marks button")
        until(page, "document.getElementById('time').textContent === '30.02 s'")
        page.keyboard.press("ArrowLeft")
        until(page, "document.getElementById('time').textContent === '30.00 s'")
        page.evaluate("document.activeElement.blur()")
        page.keyboard.press("Shift+ArrowLeft")
        until(page, "document.getElementById('time').textContent === '29.00 s'")
        page.select_option("#speed", "8")
        page.evaluate("document.activeElement.blur()")
        page.keyboard.press("Space")
        until(page, "document.getElementById('place').textContent === '32.00 / 32.00 s'")
        until(page, "document.getElementById('playback').textContent === 'Play'")
        found["buttons"] = [
            page.is_visible(f"#{name}") for name in ("play", "pause", "reset", "pace", "wheel", "playback")
        ]
        return found

    with playing(path) as player:
        found = play(player, look)
    assert len(found["marks"]) == 1
    assert found["marks"][0].startswith("30.02 s: push ")
    assert found["buttons"] == [False, False, False, False, False, True]
