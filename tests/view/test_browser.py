"""The page in a real browser: what is seen changes with the run, and what is clicked and pressed reaches it."""

from __future__ import annotations

import re
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from graphengine.api.recording_view import Playback, open_recording_page, turn
from graphengine.recording.player import RecordingPlayer
from graphengine.testing import session
from tests.recording.harness import playing
from tests.waiting import eventually

pytest.importorskip("viser", reason="the extra view is not installed")

from tests.view.chromium import browser, needs_chromium, seconds, seen, until

pytestmark = needs_chromium


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

        page.click("#world", position={"x": 200, "y": 300})  # the 3D part takes the focus
        assert page.evaluate("() => document.activeElement.id") == "world"
        page.keyboard.down("w")
        until(page, f"document.querySelector('{velocity}').textContent.startsWith('(0.5')")
        page.click("#title")  # and loses it
        until(page, f"document.querySelector('{velocity}').textContent.startsWith('(0,')")
        page.keyboard.up("w")

        page.click("#pause")
        until(page, "document.getElementById('state').textContent === 'paused'")
        found["held"] = seconds(page), seconds(page)
        page.click('[data-node="DiffController"]')
        page.fill(row, "0.25")
        page.press(row, "Enter")
        until(page, f"document.querySelector('{row}').value === '0.25'")
        page.fill(row, '"fast"')
        page.press(row, "Enter")
        until(page, "!document.getElementById('message').hidden")
        found["message"] = page.inner_text("#message-text")
        page.click("#play")
        until(page, "document.getElementById('state').textContent === 'playing'")
        assert not page.frames[1].is_visible("#webgl-software-rendering")  # it would cover the world
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
        page.click("#tree .item.graph .label:text-is('joint_states')")
        page.click('[data-node="ComputeOdom"]')
        move = "slider.value = 1800; slider.dispatchEvent(new Event('input'))"  # at once, as frames move it too
        page.evaluate(f"() => {{ const slider = document.getElementById('slider'); {move}; }}")
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
        row = 'tr[data-port="ComputeOdom.inputs:chassisPrim"] input'
        found["reasons"] = [
            (page.is_enabled(one), page.get_attribute(one, "title")) for one in ("#topics-tab", "#findings-tab", row)
        ]
        found["buttons"] = [
            page.is_visible(f"#{name}") for name in ("play", "pause", "reset", "pace", "wheel", "playback")
        ]
        return found

    with playing(path) as player:
        found = play(player, look)
    assert len(found["marks"]) == 1
    assert found["marks"][0].startswith("30.02 s: push ")
    assert found["buttons"] == [False, False, False, False, False, True]
    assert not any(enabled for enabled, _ in found["reasons"])
    assert found["reasons"][2][1] == "a recording cannot be changed"
    assert all(reason for _, reason in found["reasons"])
