"""The panes of the page in a real browser, and whether people can use them."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import graphengine as ge
from graphengine.testing import session

pytest.importorskip("viser", reason="the extra view is not installed")

from tests.view.chromium import needs_chromium, seen, until
from tests.view.harness import HOSTILE, write_lab

pytestmark = needs_chromium

FLEET = """scene: fleet
world: worlds/flat_grid.xml
robots:
  dd100: {use: robots/dd100.yaml, count: 20, per_row: 5, spacing: [1.2, 1.2], position: [0.0, 0.0, 0.025]}
"""


@pytest.fixture
def sim(tmp_path: Path) -> Iterator[ge.Session]:
    with session(write_lab(tmp_path), log=lambda *message: None) as made:
        yield made


def choose(page: Any, kind: str, name: str) -> None:
    """Click an item of the tree."""
    page.locator(f"#tree .item.{kind} .label", has_text=name).first.click()


def test_the_panes_show_the_run_and_what_strangers_wrote_is_text(sim: ge.Session) -> None:
    sim._runner.session.findings = (f"lab.yaml:3:1: error G106: unknown key {HOSTILE}",)

    def look(page: Any) -> dict[str, Any]:
        found: dict[str, Any] = {}
        choose(page, "graph", "lab")
        until(page, "document.querySelector('[data-node=\"Ratio\"] .problem.warning')")
        page.click('[data-node="Ratio"]')
        until(page, "document.querySelector('#problem')?.textContent.includes('b must be other than 0')")
        page.click('[data-node="Text"]')
        field = 'tr[data-port="Text.inputs:data"] input'
        until(page, f"document.querySelector('{field}')?.value")
        found["string"] = page.input_value(field)
        choose(page, "variable", "elapsed")
        row = 'tr[data-port="variable:elapsed"]'
        until(page, f"Number(document.querySelector('{row} .value')?.textContent) > 0.5")
        page.click(f"{row} button")
        until(page, f"document.querySelector('{row}.plotted')")
        until(page, "document.querySelector('#charts canvas').width > 100")

        page.click("#topics-tab")
        page.click("button:text-is('/text')")
        until(page, "document.querySelector('#message-rows .value')?.textContent.startsWith('<img')")
        until(
            page,
            "[...document.querySelectorAll('#topics tr.selected .number')].some((one) => one.textContent === '60.0 Hz')",
        )
        found["message"] = page.inner_text("#message-rows .value")

        page.click("#findings-tab")
        found["findings"] = page.inner_text("#findings")
        found["images"] = page.evaluate("() => document.querySelectorAll('img:not(#image)').length")
        return found

    found = seen(sim, look)
    assert found["string"] == found["message"] == HOSTILE
    assert found["images"] == 0
    assert f"error G106 unknown key {HOSTILE}" in found["findings"]
    assert "lab.yaml:3:1" in found["findings"]
    assert "warning W102 no executed node reads Idle" in found["findings"]


def test_a_robot_is_spawned_selected_and_deleted(sim: ge.Session) -> None:
    def look(page: Any) -> None:
        page.click("#spawn")
        page.fill("#spawn-use", "robots/no_such.yaml")
        page.click("#spawn-form button[type=submit]")
        until(page, "document.getElementById('spawn-error').textContent.includes('no file')")
        page.fill("#spawn-use", "robots/dd100.yaml")
        page.fill("#spawn-name", "second")
        page.fill("#spawn-x", "2")
        page.click("#spawn-form button[type=submit]")
        until(page, "document.querySelector('#tree .item.spawned.selected')")
        until(page, "document.querySelector('[data-number=x]').textContent.startsWith('2.0')")
        assert page.input_value("#robot") == "second"
        page.click("#robot-side .danger")
        until(page, "!document.querySelector('#tree .item.spawned')")

    seen(sim, look)
    assert list(sim.robots) == ["dd100"]


def test_in_a_fleet_the_tree_filters_and_is_used_from_the_keyboard(tmp_path: Path) -> None:
    path = tmp_path / "fleet.yaml"
    path.write_text(FLEET, encoding="utf-8")
    items = "[...document.querySelectorAll('#tree [role=treeitem]')]"
    names = f"{items}.filter((one) => one.offsetParent).map((one) => one.ariaLabel)"

    def look(page: Any) -> Any:
        until(page, "document.querySelectorAll('#tree .item.robot').length === 20")
        folded = page.evaluate(f"() => {names}")
        page.fill("#filter", "0007 cmd")
        filtered = page.evaluate(f"() => {names}")
        page.keyboard.press("ArrowDown")
        page.keyboard.press("ArrowDown")
        page.keyboard.press("Enter")
        until(page, "document.querySelector('#drawing .title')?.textContent === 'dd100_0007/cmd_vel'")
        page.fill("#filter", "")
        return folded, filtered

    with session(path) as sim:
        folded, filtered = seen(sim, look)
    assert folded == [f"robot dd100_{number:04}" for number in range(20)]
    assert filtered == ["robot dd100_0007", "graph cmd_vel"]


OVERLAPS = """() => {
  const seen = (one) => one.offsetParent !== null && one.getBoundingClientRect().width > 0;
  const cut = [...document.querySelectorAll("header button, header input, header select, footer .fact, [role=tab]")].filter(seen);
  const boxes = cut.map((one) => [one.id || one.textContent, one.getBoundingClientRect()]);
  const found = boxes.filter(([, box]) => box.right > innerWidth + 1 || box.bottom > innerHeight + 1).map(([name]) => name);
  for (const [name, a] of boxes) for (const [other, b] of boxes)
    if (name < other && a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 1 && b.top < a.bottom - 1)
      found.push(`${name} and ${other}`);
  return found;
}"""


SIZES = ({"width": 1280, "height": 800}, {"width": 1920, "height": 1080})


def test_contrast_and_names_pass_axe_and_nothing_overlaps(sim: ge.Session) -> None:
    package = importlib.util.find_spec("axe_playwright_python")
    if package is None or package.origin is None:
        pytest.skip("no axe-core: pip install axe-playwright-python")
    axe = Path(package.origin).with_name("axe.min.js").read_text(encoding="utf-8")

    def violations(page: Any) -> Iterator[str]:
        for scheme in ("light", "dark"):
            page.emulate_media(color_scheme=scheme)
            result = page.evaluate("() => axe.run(document, {iframes: false})")
            assert "color-contrast" in [one["id"] for one in result["passes"]]
            for one in result["violations"]:
                for node in one["nodes"]:
                    yield f"{scheme}: {one['id']}: {node['html'][:200]} {node['any'][:1]}"
        for size in SIZES:
            page.set_viewport_size(size)
            yield from (f"{size}: {what}" for what in page.evaluate(OVERLAPS))

    def look(page: Any) -> list[str]:
        page.evaluate(axe)
        choose(page, "graph", "lab")
        page.click('[data-node="Ratio"]')
        until(page, "document.querySelector('#problem b')")
        found = [*violations(page)]
        page.click("#topics-tab")
        page.click("button:text-is('/dd100_0000/odom')")
        until(page, "document.querySelectorAll('#message-rows tr').length > 5")
        found += violations(page)
        page.click("#findings-tab")
        choose(page, "robot", "dd100")
        found += violations(page)
        page.click("#wheel")
        page.click("#layers summary")
        for tab in ("plots", "images", "log"):
            page.click(f"#{tab}-tab")
            if tab == "plots":
                page.fill("#plot-add", "1 +")
                page.press("#plot-add", "Enter")
                until(page, "document.querySelector('.key .error')")
            found += violations(page)
        page.keyboard.press("?")
        found += violations(page)
        page.click("#help-close")
        page.click("#spawn")
        return [*found, *violations(page)]

    assert seen(sim, look) == []
