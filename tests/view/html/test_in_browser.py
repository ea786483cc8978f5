"""The HTML file of a recording in Chromium, opened from disk without a network."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from graphengine.api.recording_page import sample_replay
from graphengine.view.html.html_file import LogEntry, Plot, robot_plots, write_html
from tests.recording.harness import Run, playing, put, record
from tests.view.chromium import CHROMIUM, FEW_FRAMES, FLAGS, needs_chromium
from tests.view.html.worlds import SCENE, WORLD
from tests.waiting import eventually

sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe-playwright-python is not installed")

pytestmark = needs_chromium

HOSTILE = "</script><script>window.hurt = 1</script><img src=x onerror='window.hurt = 1'>"
TICKS = 120
"""Two seconds."""
DRIVE = {1: [(0.5, 0.0)], 60: [(0.5, 0.0)]}
BALL = 2.0  # m; height from which the ball of the world falls
WALL = 2.9  # m; the front of the world's wall


class Opened(NamedTuple):
    """The page in Chromium, with the addresses that it requested and the errors that it printed."""

    page: Any
    requests: list[str]
    errors: list[str]

    def seek(self, time: float) -> None:
        self.page.evaluate("time => window.recording.seek(time)", time)

    @property
    def time(self) -> float:
        return float(self.page.evaluate("() => window.recording.state.time"))

    def robot(self) -> list[float]:
        """Position of the robot in the picture, m."""
        found: list[float] = self.page.evaluate("() => window.recording.world.poseOf('dd100').position.toArray()")
        return found

    def until(self, condition: str) -> None:
        assert eventually(lambda: self.page.evaluate(f"() => {condition}"), lambda: self.page.wait_for_timeout(50))


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[tuple[float, float, float]]]:
    """The HTML file of a drive, and the position of the robot after each tick, beginning with tick 0."""
    folder = tmp_path_factory.mktemp("html")
    put(folder / "world.xml", WORLD)
    recorded, seen = folder / "out.mcap", []

    def before(tick: int, run: Run) -> None:
        seen.append(run.session.services.world.entities.state("dd100").position)

    record(recorded, TICKS, put(folder / "scene.yaml", SCENE), commands=DRIVE, before=before)
    with playing(recorded) as player:
        trace = sample_replay(player)
    trace.stages[0].robots[HOSTILE] = 0
    plots = [*robot_plots(trace), Plot(HOSTILE, [0.0, 1.0, 2.0], [0.1, 0.6, float("nan")], HOSTILE, (None, 0.5))]
    marks = [LogEntry(60, "error", HOSTILE)]
    log = [LogEntry(30, HOSTILE, HOSTILE)]
    path = folder / "out.html"
    write_html(trace, path, title=HOSTILE, plots=plots, marks=marks, log=log)
    return path, seen


@pytest.fixture(scope="module")
def driver() -> Iterator[Any]:
    with sync_api.sync_playwright() as playwright:
        yield playwright


def opened_in(driver: Any, path: Path, *flags: str) -> Opened:
    """Open the file in a new Chromium without a network."""
    chromium = driver.chromium.launch(executable_path=CHROMIUM, args=[*FLAGS, *flags])
    page = chromium.new_context(viewport={"width": 1280, "height": 800}, offline=True).new_page()
    shown = Opened(page, [], [])
    page.on("request", lambda request: shown.requests.append(request.url))
    page.on("pageerror", lambda error: shown.errors.append(str(error)))
    page.on("console", lambda told: shown.errors.append(told.text) if told.type == "error" else None)
    page.add_init_script(FEW_FRAMES)
    page.goto(path.as_uri())
    shown.until("Boolean(window.recording)")
    return shown


@pytest.fixture(scope="module")
def opened(driver: Any, driven: tuple[Path, Any]) -> Iterator[Opened]:
    shown = opened_in(driver, driven[0])
    yield shown
    shown.page.context.browser.close()


def test_the_page_makes_no_requests_and_prints_no_error(opened: Opened, driven: tuple[Path, Any]) -> None:
    opened.seek(1.0)
    opened.page.wait_for_timeout(500)
    assert (opened.requests, opened.errors) == ([driven[0].as_uri()], [])
    assert opened.page.evaluate("fetch('data:,').then(() => 'loaded', () => 'refused')") == "refused"


def test_the_time_bar_moves_the_robot_to_its_recorded_pose(opened: Opened, driven: tuple[Path, Any]) -> None:
    for tick in (0, 60, 118, 20):
        opened.page.locator("#slider").fill(str(tick / 60))
        assert opened.robot() == pytest.approx(driven[1][tick], abs=1e-5)
    assert driven[1][100][0] > driven[1][0][0] + 0.3


def test_a_ball_falls_and_a_lidar_sees_the_wall(opened: Opened) -> None:
    opened.seek(0.5)
    heights = "() => window.recording.world.stage.bodies.map(({elements}) => [elements[12], elements[14]])"
    (height,) = (z for x, z in opened.page.evaluate(heights) if x == pytest.approx(1.0, abs=0.001))
    assert height == pytest.approx(BALL - 9.81 * 0.5**2 / 2, abs=0.02)
    points = """() => {
      const { geometry } = window.recording.world.stage.lidars[0].points;
      return Array.from(geometry.attributes.position.array.subarray(0, 3 * geometry.drawRange.count));
    }"""
    found = opened.page.evaluate(points)
    ahead = [x for x, y in zip(found[::3], found[1::3], strict=True) if x > 0.5 and abs(y) < 0.5]
    assert len(ahead) > 100
    assert ahead == pytest.approx([WALL] * len(ahead), abs=0.03)  # 1 cm of rounding, and the noise of the lidar


def test_all_kinds_of_shapes_are_drawn(opened: Opened) -> None:
    drawn = "() => window.recording.world.stage.batches.length"
    assert opened.page.evaluate(drawn) == 8  # boxes with and without transparency, and six other kinds
    assert opened.page.evaluate("() => window.recording.data.textures.length") == 1
    opaque = "() => window.recording.world.stage.batches.filter(({mesh}) => mesh.material.transparent).length"
    assert opened.page.evaluate(opaque) == 1


def test_keys_and_buttons_play_and_move(opened: Opened) -> None:
    opened.page.locator("h1").click()
    opened.page.keyboard.press("Home")
    opened.page.keyboard.press("ArrowRight")
    assert opened.time == pytest.approx(1 / 60)
    opened.page.keyboard.press("Shift+ArrowRight")
    assert opened.time == pytest.approx(1 + 1 / 60)
    opened.page.keyboard.press("ArrowDown")
    assert opened.page.evaluate("() => window.recording.state.speed") == 0.5
    opened.page.keyboard.press("Home")
    opened.page.keyboard.press(" ")
    opened.until("window.recording.state.time > 0.2")
    opened.page.locator("#play").click()
    stopped = opened.time
    opened.page.wait_for_timeout(400)
    assert opened.time == stopped
    opened.page.keyboard.press("End")
    assert opened.time == pytest.approx(2.0)


def test_marks_log_entries_and_plots_select_a_time(opened: Opened) -> None:
    opened.page.locator("#marks button").click()
    assert opened.time == pytest.approx(1.0)
    opened.page.locator("#log button").first.click()
    assert opened.time == pytest.approx(0.5)
    assert opened.page.locator("#log [aria-current]").count() == 1
    over = opened.page.locator(".u-over").first
    over.click(position={"x": over.bounding_box()["width"] / 2, "y": 20})
    assert opened.time == pytest.approx(1.0, abs=0.02)
    limited = opened.page.locator("figcaption output").last
    assert (limited.inner_text(), limited.get_attribute("class")) == ("0.600", "beyond")


def test_hostile_names_and_messages_stay_text(opened: Opened) -> None:
    assert opened.page.locator("h1").inner_text() == HOSTILE
    assert opened.page.title() == HOSTILE
    assert opened.page.locator("#log .text").first.inner_text() == HOSTILE
    assert HOSTILE in opened.page.locator("#follow").inner_text()
    assert opened.page.evaluate("() => [window.hurt ?? null, document.images.length]") == [None, 0]


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1280, 800])
def test_the_page_is_accessible(opened: Opened, width: int, scheme: str) -> None:
    opened.page.set_viewport_size({"width": width, "height": 800})
    opened.page.emulate_media(color_scheme=scheme)
    found = axe.Axe().run(opened.page)
    assert found.violations_count == 0, found.generate_report()
    assert opened.page.evaluate("() => document.documentElement.scrollWidth") == width


def test_without_webgl_all_but_the_picture_works(driver: Any, driven: tuple[Path, Any]) -> None:
    shown = opened_in(driver, driven[0], "--disable-3d-apis")
    assert shown.page.locator("#no-world").inner_text().startswith("The 3D picture is missing: ")
    shown.page.locator("#marks button").click()
    assert shown.time == pytest.approx(1.0)
    shown.page.context.browser.close()
