"""The built site in a browser, opened from disk: what pages load, say and show on a phone, in light and dark."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.view.chromium import CHROMIUM, FLAGS, needs_chromium

sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe-playwright-python is not installed")

pytestmark = needs_chromium

FAMILIES = ["index", "start/install", "guide/sensors_and_cameras", "reference/nodes/time"]
"""A page of each kind, for the tests that take long."""
WIDE = ["tutorial/4_graphs", "help/symptoms", "how/rules", "reference/verbs", "reference/differences", "changelog"]
"""Pages with wide tables, blocks and drawings."""
PHONE = {"width": 375, "height": 740}


NO_SEARCH = "Object.defineProperty(window, 'Worker', {value: class { postMessage() {} terminate() {} }})"
"""Script that keeps a page from making its index of the search, which takes longer than to open the page."""


class Opened:
    """A page of the browser, with the requests that left it and the errors of its console."""

    def __init__(self, page: Any, site: Path) -> None:
        self.page, self.site = page, site
        self.requests: list[str] = []
        self.errors: list[str] = []
        page.on("request", lambda request: self.requests.append(request.url))
        page.on("console", lambda message: self.errors.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda error: self.errors.append(str(error)))

    def open(self, name: str) -> None:
        self.page.goto((self.site / f"{name}.html").as_uri(), wait_until="domcontentloaded")

    @property
    def left(self) -> list[str]:
        """The requests that went elsewhere than to the disk."""
        return [url for url in self.requests if not url.startswith(("file:", "data:", "blob:", "about:"))]


@pytest.fixture(scope="module")
def opened(site: Path) -> Iterator[Opened]:
    with sync_api.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = chromium.new_context(viewport=PHONE).new_page()
        page.add_init_script(NO_SEARCH)
        yield Opened(page, site)
        chromium.close()


def test_pages_ask_no_other_host_for_anything_and_do_not_scroll_sideways_on_a_phone(opened: Opened) -> None:
    wide = []
    for name in (*FAMILIES, *WIDE):
        opened.open(name)
        if opened.page.evaluate("document.documentElement.scrollWidth > innerWidth"):
            wide.append(name)
    assert (opened.left, opened.errors, wide) == ([], [], [])


def test_the_pages_follow_the_system_into_the_dark(opened: Opened) -> None:
    lightness = "getComputedStyle(document.body).backgroundColor.match(/[0-9.]+/g).slice(0, 3).map(Number)"
    for name in FAMILIES:
        found = {}
        for scheme in ("light", "dark"):
            opened.page.emulate_media(color_scheme=scheme)
            opened.open(name)
            found[scheme] = sum(opened.page.evaluate(lightness))
        assert found["light"] > 700 > 200 > found["dark"], (name, found)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_pages_can_be_read_by_everyone(opened: Opened, scheme: str) -> None:
    opened.page.emulate_media(color_scheme=scheme)
    for name in FAMILIES:
        opened.open(name)
        rules = {
            "runOnly": ["color-contrast", "image-alt", "link-name", "button-name", "heading-order", "html-has-lang"]
        }
        report = axe.Axe().run(opened.page, context="article", options=rules)
        assert report.violations_count == 0, f"{name}\n{report.generate_report()}"


def test_the_search_works_from_disk_and_finds_guides_and_no_changelog(opened: Opened) -> None:
    searching = Opened(opened.page.context.new_page(), opened.site)
    searching.page.set_viewport_size({"width": 1280, "height": 800})
    searching.open("index")
    searching.page.wait_for_load_state("load")
    searching.page.wait_for_selector("iframe[title=search]", state="attached")
    searching.page.keyboard.press("Control+k")
    searching.page.keyboard.type("odometry")
    results = searching.page.locator("a[href*='?h=odometry']")
    results.first.wait_for()
    targets = [link.get_attribute("href").rpartition("/site/")[2] for link in results.all()]
    assert targets[0].startswith(("guide/", "start/", "tutorial/"))
    assert [target for target in targets if "changelog" in target] == []
    assert searching.left == []
