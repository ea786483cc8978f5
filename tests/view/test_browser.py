"""The page in a real browser: what is seen changes with the run, and what is clicked and pressed reaches it."""

from __future__ import annotations

import functools
import http.server
import re
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from websockets.sync.server import serve

from graphengine.api.recording_view import Playback, open_recording_page, turn
from graphengine.recording.player import RecordingPlayer
from graphengine.testing import session
from tests.recording.harness import playing
from tests.waiting import eventually

pytest.importorskip("viser", reason="the extra view is not installed")

from graphengine.view.page_server import PageServer
from tests.view.chromium import browser, needs_chromium, seconds, seen, until

pytestmark = needs_chromium


def play(player: RecordingPlayer, look: Callable[[Any], Any]) -> Any:
    """Serve the page of a recording while a browser looks at it; what the look found."""
    playback = Playback(player)
    with closing(open_recording_page(playback, "127.0.0.1", 0)) as feed, ThreadPoolExecutor(1) as pool:

        def open_and_look() -> Any:
            with browser(feed.wait()) as page:
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
        assert page.inner_text("#held") == "W"
        page.click('[data-node="SubscribeTwist"]')
        velocity = 'tr[data-port="SubscribeTwist.outputs:linearVelocity"] .value'
        until(page, f"document.querySelector('{velocity}').textContent.startsWith('(0.5')")
        begin = seconds(page)
        assert eventually(lambda: seconds(page) > begin + 1.0, lambda: page.wait_for_timeout(50))  # it drives meanwhile
        page.keyboard.up("w")
        until(page, f"document.querySelector('{velocity}').textContent.startsWith('(0,')")

        page.click("#world", position={"x": 200, "y": 100})  # the 3D part takes the focus
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
        page.press(row, "Tab")  # which keeps what was typed
        drawn = '[data-node=DiffController] [data-port="left:maxLinearSpeed"] .value'
        until(page, f"document.querySelector('{drawn}').textContent.trim() === '0.25'")
        page.fill(row, '"fast"')
        page.press(row, "Enter")
        until(page, "document.querySelector('.refused:not([hidden])')")
        found["message"] = page.inner_text(".refused:not([hidden])")
        assert page.input_value(row) == '"fast"'
        assert page.is_hidden("#message")  # over which the drawing would be hidden
        page.press(row, "Escape")
        until(page, f"document.querySelector('{row}').value === '0.25'")
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


def test_without_the_token_the_page_shows_nothing_of_the_run_and_says_what_to_open() -> None:
    with session("dd100_flat") as sim:
        base = sim.view().partition("#")[0]
        with browser(base) as page:
            page.wait_for_selector("#failure:visible")
            assert "Open the address that graphrun printed" in page.inner_text("#failure")
            assert page.inner_text("#title") == "graphrun"
            assert len(page.frames) == 2
            assert page.frames[1].url == "about:blank"


def test_the_page_removes_the_token_from_its_address_and_keeps_it_for_the_tab() -> None:
    def look(page: Any) -> None:
        until(page, "document.getElementById('title').textContent === 'dd100_flat'")
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+/(#robot=dd100&graph=dd100%2F\w+)?", page.url)
        assert page.context.cookies() == []
        page.reload()
        until(page, "document.getElementById('title').textContent === 'dd100_flat'")
        other = page.context.new_page()
        other.goto(page.url)
        other.wait_for_selector("#failure:visible")
        other.goto(f"{page.url.partition('#')[0]}#token={token(page)}")  # another fragment alone loads no page
        other.wait_for_selector("#title:text-is('dd100_flat')")

    def token(page: Any) -> str:
        return str(page.evaluate("() => sessionStorage.getItem('token')"))

    with session("dd100_flat") as sim:
        seen(sim, look)


def test_a_page_of_another_port_neither_reads_nor_drives(tmp_path: Path) -> None:
    """A stranger's page on the same host tries the sockets, with all that its browser has of the run's page."""
    (tmp_path / "index.html").write_text("<!doctype html><title>another</title>", encoding="utf-8")
    headers: list[str] = []

    class Handler(http.server.SimpleHTTPRequestHandler):
        def log_request(self, code: Any = "-", size: Any = "-") -> None:
            headers.append(str(self.headers))

    handler = functools.partial(Handler, directory=str(tmp_path))
    attempt = """([base, token]) => Promise.all(["feed", "3d"].map((path) => new Promise((resolve) => {
        const socket = new WebSocket(`${base}${path}?token=${token}`);
        socket.onopen = () => resolve("open");
        socket.onerror = () => resolve("refused");
    })))"""

    def look(page: Any) -> None:
        until(page, "document.getElementById('title').textContent === 'dd100_flat'")
        other = page.context.new_page()
        other.goto(f"http://127.0.0.1:{server.server_address[1]}/index.html")
        stored = other.evaluate("() => [document.cookie, sessionStorage.getItem('token')]")
        assert stored == ["", None]
        token = page.evaluate("() => sessionStorage.getItem('token')")
        for tried in ("", token):  # even who has the token is refused, for its origin
            base = page.url.partition("#")[0].replace("http", "ws")
            assert other.evaluate(attempt, [base, tried]) == ["refused", "refused"]
        assert "ookie" not in "".join(headers)

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server, session("dd100_flat") as sim:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        seen(sim, look)
        server.shutdown()


def test_the_3d_part_connects_to_no_other_server_although_its_address_names_one() -> None:
    """A server of a stranger could run scripts in the page, and those could read the token."""
    heard: list[object] = []
    attempt = "url => new Promise((done) => { new WebSocket(url).onerror = () => done('refused'); })"
    with (
        serve(heard.append, "127.0.0.1", 0) as stranger,
        closing(PageServer("127.0.0.1", 0, lambda viewer, message: None, dict)) as server,
    ):
        threading.Thread(target=stranger.serve_forever, daemon=True).start()
        other = f"ws://127.0.0.1:{stranger.socket.getsockname()[1]}/"
        with browser(f"http://127.0.0.1:{server.port}/") as page:
            said: list[str] = []
            page.on("console", lambda message: said.append(message.text))
            page.goto(f"http://127.0.0.1:{server.port}/3d/?websocket={other}")
            assert eventually(
                lambda: any(f"Connecting to: {other}" in text for text in said), lambda: page.wait_for_timeout(50)
            )
            assert page.evaluate(attempt, other) == "refused"
    assert heard == []


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
