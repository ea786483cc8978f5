"""Plots, the log, and what follows a selection, in a real browser."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

import pytest

from graphengine.testing import session
from tests.recording.harness import playing

pytest.importorskip("viser", reason="the extra view is not installed")

from tests.view.chromium import needs_chromium, seen, until
from tests.view.test_browser import play

pytestmark = needs_chromium
KEYS = "[...document.querySelectorAll('.key')].map((one) => one.textContent)"


def saved(page: Any, button: str) -> bytes:
    """The file that a button of the first plot saves."""
    with page.expect_download() as download:
        page.click(f".chart-actions button:text-is('{button}')")
    return Path(download.value.path()).read_bytes()


def rows(page: Any) -> tuple[list[str], list[list[float | None]]]:
    """The head and the numbers of the saved table."""
    head, *lines = csv.reader(io.StringIO(saved(page, "CSV").decode()))
    return head, [[float(cell) if cell else None for cell in line] for line in lines]


def test_ports_elements_and_message_fields_are_plotted_and_stay(tmp_path: Path) -> None:
    def look(page: Any) -> Any:
        page.click("#tree .item.graph .label:text-is('joint_states')")
        page.click('[data-node="ComputeOdom"]')
        page.click('tr[data-port="ComputeOdom.outputs:position"] button')  # three numbers
        until(page, f"{KEYS}.length === 3")
        page.fill("#plot-add", "/dd100_0000/odom.twist.twist.linear.x")
        page.press("#plot-add", "Enter")
        page.fill("#plot-add", "1 +")
        page.press("#plot-add", "Enter")
        until(page, "document.querySelector('.key .error')")
        error = page.inner_text(".key .error")
        page.click(".key:has(.error) button")
        page.click("#topics-tab")  # other things are shown
        page.click("#tree .item.graph .label:text-is('cmd_vel')")
        page.click("#plots-tab")
        page.wait_for_timeout(1500)
        head, numbers = rows(page)
        picture = saved(page, "PNG")
        page.reload()
        until(page, f"{KEYS}.length === 4")
        return error, head, numbers, picture

    with session("dd100_flat") as sim:
        error, head, numbers, picture = seen(sim, look)
    assert "not an expression" in error
    port = 'port("dd100/joint_states/ComputeOdom.outputs:position")'
    field = 'message("/dd100_0000/odom").twist.twist.linear.x'
    assert head == ["time_s", *(f"{port}[{index}] m" for index in range(3)), field]
    whole = [line for line in numbers if None not in line]
    assert len(whole) > 60
    assert picture.startswith(b"\x89PNG")


def test_a_field_is_plotted_over_a_whole_recording_and_a_click_goes_to_its_time(tmp_path: Path) -> None:
    path = tmp_path / "out.mcap"
    with session("dd100_flat", record=path) as sim:
        topic = sim.subscribe("/dd100_0000/odom")
        sim.robots["dd100"].publish("cmd_vel", {"linear": {"x": 0.4}}, every=0.1)
        sim.run(4.0)
        assert topic.latest is not None
        last = topic.latest.pose.pose.position.x

    def look(page: Any) -> Any:
        until(page, "document.getElementById('verdict').textContent === 'identical'")
        page.click("#plots-tab")
        page.fill("#plot-add", "/dd100_0000/odom")
        page.press("#plot-add", "Enter")
        page.select_option(".key select", ".pose.pose.position.x")
        until(page, "Number(document.querySelector('.key output')?.textContent) > 1.0")
        box = page.locator(".u-over").bounding_box()
        page.mouse.click(box["x"] + box["width"] / 2, box["y"] + 20)
        until(page, "document.getElementById('place').textContent.startsWith('2.0')")
        return rows(page)[1]

    with playing(path) as player:
        numbers = play(player, look)
    assert [line[0] for line in numbers] == pytest.approx([(tick + 1) / 60 for tick in range(240)])
    assert numbers[-1][1] == pytest.approx(last)
