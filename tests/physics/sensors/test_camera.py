"""When pictures are captured and delivered, what they are made of, and that none of it depends on time or on others."""

from __future__ import annotations

import gc
import math
import threading
import weakref
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from graphengine.descriptions.engine import mujoco
from graphengine.devices.camera import Picture
from graphengine.physics.pictures.frame_capture import Shot
from graphengine.physics.pictures.rendering import Image
from graphengine.physics.sensors.camera import PinholeCamera
from graphengine.physics.simulation import Simulation
from tests.other_process import in_another_process
from tests.physics.conftest import Ship
from tests.physics.pictures.harness import camera_of, filming, needs_opengl, simulation_of

pytestmark = needs_opengl

BALL = '<body name="ball" pos="3 0 2"><freejoint/><geom type="sphere" size=".4" rgba="1 .2 .1 1"/></body>'
FALLING = f'<geom type="plane" size="0 0 1" rgba=".4 .5 .6 1"/>{BALL}'
WALL = '<geom type="box" size=".1 90 90" pos="{} 0 1" rgba=".5 .5 .5 1"/>'
D455 = "/dd100/base_link/chassis_link/sim_camera/RSD455/Camera_OmniVision_OV9782_Color"


def play(simulation: Simulation, camera: PinholeCamera, ticks: int, first: int = 1) -> dict[int, Picture]:
    """Step and ask in each tick; what was delivered, by tick."""
    pictures = {}
    for tick in range(first, first + ticks):
        simulation.step()
        simulation.begin_tick(tick)
        camera.request()
        if (picture := camera.delivered()) is not None:
            pictures[tick] = picture
    return pictures


def digest(pictures: dict[int, Picture]) -> dict[int, tuple[float, int, bytes, bytes]]:
    return {tick: (p.time, p.index, p.rgb.tobytes(), p.depth.tobytes()) for tick, p in pictures.items()}


@pytest.mark.parametrize(
    ("tick_rate", "rate", "latency"),
    [(60, 30.0, 0.05), (60, 25.0, 0.1), (100, 7.0, 0.033), (60, 60.0, 0.0), (50, 120.0, 0.2)],
)
def test_a_picture_is_delivered_exactly_its_latency_after_its_capture(
    tick_rate: int, rate: float, latency: float
) -> None:
    simulation, camera = filming(FALLING, tick_rate=tick_rate, rate=rate, latency=latency)
    delay = max(1, math.ceil(Fraction(str(latency)) * tick_rate))
    assert camera.latency == delay
    due = {}
    for tick in range(1, 41):  # of the samples n with n / rate <= t, the newest; the first tick has one
        newest = math.floor(Fraction(tick, tick_rate) * Fraction(str(rate)))
        if tick == 1 or newest > math.floor(Fraction(tick - 1, tick_rate) * Fraction(str(rate))):
            due[tick] = newest
    pictures = play(simulation, camera, 40)
    assert {tick - delay: picture.index for tick, picture in pictures.items()} == {
        tick: index for tick, index in due.items() if tick + delay <= 40
    }
    for tick, picture in pictures.items():
        assert picture.time == pytest.approx((tick - delay) / tick_rate, rel=1e-12)


def test_an_image_shows_the_tick_of_its_capture_and_not_of_its_delivery() -> None:
    simulation, camera = filming(BALL, latency=0.2)
    heights: dict[int, float] = {}
    pictures: dict[int, Picture] = {}
    for tick in range(1, 31):
        pictures |= play(simulation, camera, 1, tick)
        heights[tick] = simulation.data.body("ball").xpos[2]
    _, fy, _, cy = camera.intrinsics
    for tick, picture in pictures.items():
        rows = np.nonzero(np.isfinite(picture.depth))[0]
        assert (rows.min() + rows.max()) / 2 == pytest.approx(
            cy - fy * (heights[tick - camera.latency] - 1.0) / 3.0, abs=1.0
        )
    assert len(pictures) > 5


def test_all_readers_get_the_same_picture_and_it_is_drawn_once(monkeypatch: pytest.MonkeyPatch) -> None:
    simulation = simulation_of(FALLING)
    camera, same = camera_of(simulation), camera_of(simulation, (64, 48))
    assert camera is same
    shots: list[int] = []
    capture = simulation.studio.capture

    def counted(*given: Any, **more: Any) -> Shot:
        shots.append(simulation.tick)
        return capture(*given, **more)

    monkeypatch.setattr(simulation.studio, "capture", counted)
    for tick in range(1, 5):
        simulation.begin_tick(tick)
        for _ in range(3):
            camera.request()
            first, second = camera.delivered(), same.delivered()
            assert first is second
            assert (first is not None) == (tick == 4)
    assert shots == [1, 2, 4]
    assert first is not None
    assert not first.rgb.flags.writeable
    assert not first.depth.flags.writeable


def test_an_image_not_collected_in_its_tick_is_dropped() -> None:
    simulation, camera = filming(FALLING)
    simulation.begin_tick(2)
    camera.request()
    simulation.begin_tick(6)
    assert camera.delivered() is None
    simulation.begin_tick(5)
    assert camera.delivered() is None


def test_segments_come_from_the_tick_on_in_which_the_first_reader_asks() -> None:
    simulation, camera = filming(FALLING)
    seen = {}
    for tick in range(1, 11):
        simulation.begin_tick(tick)
        camera.request()
        if tick == 4:
            camera.request(segmentation=True)  # by a second reader, after the first
        if (picture := camera.delivered()) is not None:
            seen[tick - camera.latency] = picture.segmentation is not None
    assert seen == {1: False, 2: False, 4: True, 6: True}


def test_pictures_of_another_size_see_the_same_from_left_to_right() -> None:
    simulation = simulation_of(FALLING)
    small, large = camera_of(simulation), camera_of(simulation, (128, 96))
    assert small.intrinsics[0] * 2 == pytest.approx(large.intrinsics[0])
    assert large.picture().depth.shape == (96, 128)
    floor = small.picture().depth[40], large.picture().depth[80:82].mean(axis=0)
    np.testing.assert_allclose(floor[0], floor[1].reshape(64, 2).mean(axis=1), rtol=1e-3)


@pytest.fixture
def busy() -> Iterator[tuple[Simulation, threading.Event]]:
    """A simulation in real time, whose drawing thread does nothing until the event is set."""
    simulation, free = simulation_of(FALLING, latency=0.05), threading.Event()
    camera = camera_of(simulation)
    shot = simulation.studio.capture(((0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 1.0)), camera._lens)

    def wait(_: Image) -> Picture:
        free.wait(30)
        return Picture(0.0, 0, np.zeros((1, 1, 3), np.uint8), np.zeros((1, 1), np.float32))

    simulation.studio.draw(shot, wait)
    yield simulation, free
    free.set()
    simulation.close()


def test_in_real_time_late_pictures_are_dropped_and_counted(busy: tuple[Simulation, threading.Event]) -> None:
    simulation, free = busy
    camera = camera_of(simulation)
    simulation.realtime = True
    assert play(simulation, camera, 12) == {}
    # Those of ticks 1 and 6 are late; those of 2, 4, 8 and 12 find another before them.
    assert simulation.dropped_pictures == {"/Camera": 6}
    free.set()
    for exposure in camera._pending:
        exposure.picture.result()
    pictures = play(simulation, camera, 3, 13)
    assert {tick: picture.index for tick, picture in pictures.items()} == {13: 5}
    simulation.reset()
    assert simulation.dropped_pictures == {}


def test_without_real_time_the_tick_waits(busy: tuple[Simulation, threading.Event]) -> None:
    simulation, free = busy
    camera = camera_of(simulation)
    threading.Timer(0.1, free.set).start()
    assert list(play(simulation, camera, 6)) == [4, 5]
    assert simulation.dropped_pictures == {}


def noisy(seed: int = 0) -> Simulation:
    return simulation_of(FALLING, seed=seed, colour_noise=4.0, depth_noise=0.002)


def noisy_run() -> dict[int, tuple[float, int, bytes, bytes]]:
    simulation = noisy()
    return digest(play(simulation, camera_of(simulation), 20))


def test_runs_of_two_processes_give_the_same_bytes_and_reset_begins_the_second() -> None:
    simulation, other = noisy(), noisy(seed=1)
    first = digest(play(simulation, camera_of(simulation), 20))
    assert len(first) > 5
    simulation.reset()
    assert digest(play(simulation, camera_of(simulation), 20)) == first
    assert in_another_process(noisy_run) == first
    assert digest(play(other, camera_of(other), 20)) != first


def test_other_readers_do_not_change_the_images() -> None:
    alone = simulation_of(FALLING, colour_noise=4.0)
    expected = digest(play(alone, camera_of(alone), 12))
    crowded, another = simulation_of(FALLING, colour_noise=4.0), simulation_of(WALL.format(2))
    camera, wide = camera_of(crowded), camera_of(crowded, (96, 64))
    seen: dict[int, Picture] = {}
    for tick in range(1, 13):
        wide.request(segmentation=True)
        seen |= play(crowded, camera, 1, tick)
        wide.request()
        play(another, camera_of(another), 1, tick)
        wide.delivered()
    assert digest(seen) == expected


def test_a_samples_noise_does_not_depend_on_the_samples_before() -> None:
    simulation = simulation_of(WALL.format(3), colour_noise=4.0)
    every = play(simulation, camera_of(simulation), 12)
    late = simulation_of(WALL.format(3), colour_noise=4.0)
    only = play(late, camera_of(late), 4, 6)
    assert only[9].index == every[9].index == 3
    assert only[9].rgb.tobytes() == every[9].rgb.tobytes()
    assert every[7].rgb.tobytes() != every[9].rgb.tobytes()


def test_noise_has_the_size_that_the_profile_says() -> None:
    def picture(distance: float, colour: float = 0.0, depth: float = 0.0) -> Picture:
        wall = WALL.format(distance + 0.1)
        return camera_of(simulation_of(wall, size=(160, 120), colour_noise=colour, depth_noise=depth)).picture()

    plain, noisy = picture(3.0), picture(3.0, colour=5.0)
    assert np.std(noisy.rgb.astype(float) - plain.rgb) == pytest.approx(math.hypot(5.0, 12**-0.5), rel=0.02)
    for distance in (1.0, 4.0):
        depth = picture(distance, depth=0.003).depth
        assert np.mean(depth) == pytest.approx(distance, abs=0.003 * distance**2 / 20)
        assert np.std(depth) == pytest.approx(0.003 * distance**2, rel=0.05)


def test_noise_stays_within_the_reported_range() -> None:
    simulation = simulation_of(WALL.format(4.1), depth_noise=1.0, colour_noise=200.0, clip=(3.0, 5.0))
    picture = camera_of(simulation).picture()
    assert np.isfinite(picture.depth).all()
    assert picture.depth.min() == 3.0
    assert picture.depth.max() == 5.0
    assert [int(picture.rgb.min()), int(picture.rgb.max())] == [0, 255]


def test_a_picture_on_its_way_survives_an_exchange_of_the_model() -> None:
    simulation, camera = filming(WALL.format(3.1), latency=0.05)
    simulation.begin_tick(2)
    camera.request()
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{WALL.format(7.1)}</worldbody></mujoco>")
    simulation.rebind(model, mujoco.MjData(model))
    simulation.begin_tick(4)
    camera.request()
    depths = []
    for tick in (5, 7):
        simulation.begin_tick(tick)
        picture = camera.delivered()
        assert picture is not None
        depths.append(float(picture.depth[24, 32]))
    assert depths == pytest.approx([3.0, 7.0], abs=1e-4)


def test_closing_cancels_pending_images() -> None:
    simulation, camera = filming(FALLING, size=(640, 480), latency=5.0)
    for tick in range(1, 60):
        simulation.begin_tick(tick)
        camera.request()
    pending = [exposure.picture for exposure in camera._pending]
    simulation.close()
    assert all(picture.done() for picture in pending)
    assert sum(picture.cancelled() for picture in pending) > 20
    simulation.close()
    assert camera.picture().rgb.any()  # who still asks is served
    simulation.close()


def drawing_threads() -> int:
    gc.collect()
    return sum(thread.name == "render" for thread in threading.enumerate())


def test_a_simulation_that_is_closed_or_forgotten_leaves_no_thread() -> None:
    before = drawing_threads()
    closed, forgotten = simulation_of(FALLING), simulation_of(FALLING)
    for simulation in (closed, forgotten):
        camera_of(simulation).picture()
    assert drawing_threads() == before + 2
    closed.close()
    assert drawing_threads() == before + 1
    gone = weakref.ref(forgotten)
    del forgotten, simulation
    assert drawing_threads() == before
    assert gone() is None


def test_without_a_request_no_image_is_rendered_and_no_thread_is_started() -> None:
    before = drawing_threads()
    simulation, camera = filming(FALLING)
    for tick in range(1, 10):
        simulation.begin_tick(tick)
        assert camera.delivered() is None
    assert drawing_threads() == before


def test_the_d455_sees_the_warehouse_in_front_of_the_robot(ship: Ship) -> None:
    simulation = ship("dd100_warehouse.yaml").simulation
    camera = simulation.device(PinholeCamera, simulation.stage.find(D455))
    assert camera.size == (1280, 800)
    focal = 640 / math.tan(math.radians(45.25))
    assert camera.intrinsics == pytest.approx((focal, focal, 639.5, 399.5))
    small = simulation.device(PinholeCamera, simulation.stage.find(D455), size=(160, 100))
    picture = small.picture(segmentation=True)
    assert picture.segmentation is not None
    seen = {small.labels[number] for number in np.unique(picture.segmentation).tolist() if number}
    assert {"/World", "/World/forklift_01", "/World/rack_09"} <= seen
    assert not any(path.startswith("/dd100") for path in seen)
    assert np.median(picture.depth[99]) == pytest.approx(0.0645 * focal / 8 / 49.5, rel=0.05)  # the floor, below it
    simulation.close()


def test_a_preview_shows_this_instant_and_changes_no_picture_that_is_delivered() -> None:
    simulation, camera = filming(FALLING, colour_noise=3.0)
    other, plain = filming(FALLING, colour_noise=3.0)
    delivered = {}
    for tick in range(1, 21):
        simulation.step()
        simulation.begin_tick(tick)
        preview = camera.preview()
        camera.request()
        if (picture := camera.delivered()) is not None:
            delivered[tick] = picture
            assert camera.latest is picture
        assert preview.result().time == simulation.time
    assert digest(delivered) == digest(play(other, plain, 20))
