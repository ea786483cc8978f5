"""The page in a real browser: what is seen changes with the run, and what is clicked and pressed reaches it."""

from __future__ import annotations

import re
from typing import Any

import pytest

from graphengine.testing import session
from tests.waiting import eventually

pytest.importorskip("viser", reason="the extra view is not installed")

from tests.view.chromium import browser, needs_chromium, seconds, seen, until

pytestmark = [pytest.mark.xdist_group("view"), needs_chromium]


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
