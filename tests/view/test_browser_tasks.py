"""What an engineer does in the page: follow, step, search, read the log, restart the run, move joints, look through cameras."""

from __future__ import annotations

import socket
from pathlib import Path
from typing import Any

import pytest

import graphengine as ge
from graphengine.testing import session

pytest.importorskip("viser", reason="the extra view is not installed")

from tests.view.chromium import browser, needs_chromium, seen, until
from tests.view.harness import write_lab
from tests.view.test_browser_panes import FLEET, choose
from tests.waiting import eventually

pytestmark = needs_chromium

LINK = """<link name="{name}"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
ARM = f"""<robot name="arm">{LINK.format(name="base_link")}{LINK.format(name="upper")}{LINK.format(name="tool")}
<joint name="shoulder" type="revolute"><parent link="base_link"/><child link="upper"/><axis xyz="0 0 1"/>
<limit lower="-1.5" upper="1.25" effort="500" velocity="20"/></joint>
<joint name="drill" type="continuous"><parent link="upper"/><child link="tool"/><axis xyz="0 0 1"/>
<limit effort="500" velocity="6"/></joint></robot>"""
ROBOT = """robot: arm
urdf: arm.urdf
fixed_base: true
joints: {shoulder: {drive: {stiffness: 800, damping: 80}}, drill: {drive: {damping: 50}}}
"""
KEYS = """graph: keys
nodes:
  Tick: OnPlaybackTick
  Key: {type: ReadKeyboardState, inputs: {key: K}}
  Say: {type: ROS2Publisher, inputs: {topicName: /key, messagePackage: std_msgs, messageName: Bool}}
  Print: {type: PrintText, inputs: {text: the arm is ready, logLevel: Warning}}
connections: [Tick.tick -> Say.execIn, Key.isPressed -> Say.data, Tick.tick -> Print.execIn]
"""
SCENE = """scene: cell
world: worlds/flat_grid.xml
robots: {arm: {use: arm.yaml, position: [0, 0, 1]}}
graphs: {keys: {use: keys.yaml, at: /World/keys}}
"""


@pytest.fixture
def cell(tmp_path: Path) -> Path:
    for name, text in {"arm.urdf": ARM, "arm.yaml": ROBOT, "keys.yaml": KEYS, "scene.yaml": SCENE}.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path / "scene.yaml"


def slide(page: Any, joint: str, value: float) -> None:
    """Move the slider of a joint."""
    page.locator(f'input[aria-label="target of {joint}"]').evaluate(
        f"slider => {{ slider.value = {value}; slider.dispatchEvent(new Event('input')); }}"
    )


def test_joints_have_sliders_with_their_limits_and_keys_reach_the_nodes_that_read_them(cell: Path) -> None:
    def look(page: Any) -> Any:
        choose(page, "robot", "arm")
        until(page, "document.querySelectorAll('.joints input').length === 2")
        slider = page.locator('input[aria-label="target of shoulder"]')
        limits = [float(slider.get_attribute(name)) for name in ("min", "max")]
        slide(page, "shoulder", 0.5)
        slide(page, "drill", 3.0)
        until(page, "Math.abs(Number(document.querySelector('.joints output')?.textContent) - 0.5) < 0.01")

        page.click("#wheel")  # there is nothing to drive
        page.keyboard.down("k")
        choose(page, "graph", "keys")
        page.click('[data-node="Key"]')
        pressed = "document.querySelector('tr[data-port=\"Key.outputs:isPressed\"] .value')?.textContent"
        until(page, f"{pressed} === 'true'")
        page.keyboard.up("k")
        until(page, f"{pressed} === 'false'")

        page.click("#log-tab")
        until(page, "document.querySelector('.line.warning .text')?.textContent === 'the arm is ready'")
        until(page, "Number(document.querySelector('.times')?.textContent.slice(2)) > 60")
        assert page.locator(".line.warning").count() == 1
        page.select_option("#log-level", "error")
        assert page.locator(".line:visible").count() == 0
        page.select_option("#log-level", "info")
        page.click(".line.warning button")
        until(page, "document.querySelector('[data-node=Print].selected')")
        return limits

    with session(cell, log=lambda *message: None) as sim:
        limits = seen(sim, look)
        assert limits == pytest.approx([-1.5, 1.25])
        assert sim.robots["arm"].joints["shoulder"].position == pytest.approx(0.5, abs=0.01)
        assert sim.robots["arm"].joints["drill"].velocity == pytest.approx(3.0, abs=0.05)


def test_a_step_shows_what_ran_in_its_order_and_a_search_finds_nodes(tmp_path: Path) -> None:
    def look(page: Any) -> Any:
        choose(page, "graph", "lab")
        until(page, "document.querySelector('[data-node=Tick].ran')")
        page.click("#pause")
        until(page, "document.getElementById('state').textContent === 'paused'")
        page.click("#step")
        page.wait_for_timeout(1000)  # many frames without a tick
        order = {
            name: page.text_content(f'[data-node="{name}"] .order').strip(". ")
            for name in ("Tick", "Write", "Nothing", "Ratio", "Say", "Text", "Idle")
        }
        page.keyboard.press("Control+f")
        page.keyboard.type("topicName")
        found = [page.inner_text("#graph-found")]
        page.keyboard.press("Enter")
        page.keyboard.press("Enter")
        found.append(page.inner_text("#graph-found"))
        selected = page.evaluate("() => document.querySelector('[data-node].selected').dataset.node")
        lit = page.evaluate("() => [...document.querySelectorAll('.lit')].map((one) => one.dataset.from)")
        wide = "() => document.querySelector('#drawing svg').viewBox.baseVal.width"
        before = page.evaluate(wide)
        page.click("#graph-in")
        assert page.evaluate(wide) == pytest.approx(before / 1.25)
        return order, found, selected, lit, page.url

    with session(write_lab(tmp_path), log=lambda *message: None) as sim:
        order, found, selected, lit, url = seen(sim, look)
    assert order["Idle"] == ""
    ran = sorted((int(number), name) for name, number in order.items() if number)
    assert ran[0] == (1, "Tick")
    places = [name for _, name in ran]
    assert places.index("Nothing") < places.index("Ratio") < places.index("Say")
    assert found == ["2 found", "2 of 2"]
    assert selected in ("Say", "Text")
    assert "Tick" in lit
    assert f"node={selected}" in url


def test_a_new_run_on_the_same_port_shows_itself_in_the_open_tab_with_the_same_selection(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    with socket.create_server(("127.0.0.1", 0)) as probe:
        port = probe.getsockname()[1]

    def run(sim: ge.Session, condition: Any) -> None:
        assert eventually(condition, lambda: sim.run(0.2, rate=1.0))

    with session("dd100_flat") as sim:
        first = sim.view(port=port)
        with browser(first) as page:
            run(sim, lambda: page.locator("[data-node]").count() > 0)
            page.click("#tree .item.graph .label:text-is('joint_states')")
            run(sim, lambda: page.locator("[data-node=ComputeOdom]").count() > 0)
            page.click("[data-node=ComputeOdom]")
            sim.close()
            page.wait_for_selector("#state:text-is('ended')")
            with session("dd100_flat") as again:
                assert again.view(port=port) == first
                run(again, lambda: page.locator("[data-node=ComputeOdom].selected").count() > 0)
                run(again, lambda: page.inner_text("#state") == "playing" or page.inner_text("#time") != "0.00 s")


def test_in_a_fleet_two_browsers_follow_different_robots(tmp_path: Path) -> None:
    path = tmp_path / "fleet.yaml"
    path.write_text(FLEET, encoding="utf-8")

    def look(page: Any) -> Any:
        choose(page, "robot", "dd100_0007")
        until(page, "document.getElementById('picked').textContent === 'dd100_0007'")
        page.click("#tree [aria-label='robot dd100_0007'] .fold")
        page.click("#tree [aria-label='robot dd100_0007'] .item.graph .label:text-is('cmd_vel')")
        other = page.context.new_page()
        other.goto(f"{page.url.partition('#')[0]}#token={page.evaluate('() => sessionStorage.token')}&robot=dd100_0003")
        until(other, "document.getElementById('picked').textContent === 'dd100_0003'")
        until(other, "document.querySelector('#tree .item.robot.selected .label')?.textContent === 'dd100_0003'")
        choose(other, "robot", "dd100_0004")
        # A graph of another robot that is called like the selected one comes with the robot.
        choose(page, "robot", "dd100_0008")
        until(page, "document.querySelector('#drawing .title')?.textContent === 'dd100_0008/cmd_vel'")
        return [one.inner_text("#picked") for one in (page, other)]

    with session(path) as sim:
        assert seen(sim, look) == ["dd100_0008", "dd100_0004"]


def test_an_object_is_moved_to_numbers_values_are_copied_and_a_camera_is_seen_large() -> None:
    def look(page: Any) -> Any:
        page.context.grant_permissions(["clipboard-read", "clipboard-write"])
        page.locator("#tree .item.folder .label", has_text="objects").click()
        choose(page, "object", "box_01")
        until(page, "document.querySelector('[data-number=x]')?.textContent !== ''")
        page.fill(".move [name=x]", "1.5")
        page.fill(".move [name=y]", "-2")
        page.click(".move button")
        until(page, "document.querySelector('.move .refused').textContent.includes('deep in rack_05')")
        page.fill(".move [name=x]", "0.5")
        page.fill(".move [name=y]", "-1")
        page.fill(".move [name=z]", "0.6")
        page.click(".move button")
        until(page, "document.querySelector('[data-number=x]')?.textContent.startsWith('0.5')")
        page.click("[data-number=y] button")
        copied = float(page.evaluate("() => navigator.clipboard.readText()"))

        page.click("#images-tab")
        until(page, "document.getElementById('image').naturalWidth >= 640")
        page.check("#depth")
        until(page, "document.getElementById('image-range').textContent.includes('m (red) to')")

        page.keyboard.press("Escape")
        page.click("#title")
        page.keyboard.press("?")
        until(page, "document.getElementById('help-dialog').open")
        assert "find nodes" in page.inner_text("#help-list")
        return copied

    with session("dd100_warehouse") as sim:
        copied = seen(sim, look)
        assert copied == pytest.approx(-1.0, abs=0.05)
        assert sim.body("box_01").pose.position[0] == pytest.approx(0.5, abs=0.05)


def test_the_page_says_why_a_robot_stands_and_shows_the_evidence(tmp_path: Path) -> None:
    def look(page: Any) -> Any:
        choose(page, "robot", "dd100")
        page.click("text=Why does it stand?")
        until(
            page,
            "document.querySelector('#why .sentence').textContent.startsWith('nobody publishes on /dd100_0000/cmd_vel')",
        )
        page.click("#why summary")
        return page.inner_text("#why ul")

    with session("dd100_flat", rays="mujoco", log=lambda *message: None) as sim:
        evidence = seen(sim, look)
    assert "front_left_wheel_joint: at " in evidence
    assert "dd100/cmd_vel/DiffController.velocityCommand = (0, 0) rad/s" in evidence


def test_an_edited_value_is_written_to_its_file_and_taken_back(tmp_path: Path) -> None:
    graph = "graph: one\nnodes:\n  Tick: OnPlaybackTick\n  Limit: {type: ConstantDouble, inputs: {value: 1.3}}  # m/s\n"
    (tmp_path / "one.yaml").write_text(graph, encoding="utf-8")

    def look(page: Any) -> Any:
        choose(page, "graph", "one")
        page.click('[data-node="Limit"]')
        field = 'tr[data-port="Limit.inputs:value"] input'
        until(page, f"document.querySelector('{field}')?.value === '1.3'")
        page.fill(field, "0.2")
        page.press(field, "Enter")
        page.click(".save button")
        until(page, "document.querySelector('.save .change').textContent.startsWith('value: 1.3 -> 0.2 in ')")
        before = (tmp_path / "one.yaml").read_text(encoding="utf-8")
        page.click(".save >> text=Write")
        until(page, "document.querySelector('div.save .change')?.textContent.startsWith('value: 1.3 -> 0.2 in ')")
        written = (tmp_path / "one.yaml").read_text(encoding="utf-8")
        page.click("text=Undo")
        until(page, "document.querySelector('div.save button')?.textContent === 'Redo'")
        return before, written, (tmp_path / "one.yaml").read_text(encoding="utf-8")

    with session(tmp_path / "one.yaml", log=lambda *message: None) as sim:
        sim._runner.session.edits = True
        before, written, undone = seen(sim, look)
    assert before == undone == graph
    assert written == graph.replace("1.3", "0.2")
