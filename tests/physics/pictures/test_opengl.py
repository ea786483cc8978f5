"""Drawing without a window: without OpenGL, by several threads, after refusals, in copies of the process."""

from __future__ import annotations

import os
import re
import signal
import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager, suppress

import pytest

from graphengine.descriptions.engine import mujoco
from graphengine.format.errors import RenderError
from graphengine.physics.pictures import opengl
from graphengine.physics.simulation import Simulation
from tests.physics.pictures.harness import ROOM, camera_of, filming, needs_opengl, simulation_of, take_opengl_away


@pytest.fixture
def no_libraries(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    take_opengl_away(monkeypatch)
    yield
    opengl._platform.cache_clear()


@pytest.mark.usefixtures("no_libraries")
def test_without_opengl_the_packages_to_install_are_named() -> None:
    camera = camera_of(simulation_of(ROOM))
    with pytest.raises(RenderError) as caught:
        camera.picture()
    told = str(caught.value).splitlines()
    assert told[0] == "rendering images needs OpenGL, which does not work here"
    assert "EGL: libEGL.so.1: cannot open shared object file: No such file or directory" in told
    assert any(line.startswith("OSMesa: libOSMesa") for line in told)
    assert any("apt-get install libegl1 libgl1-mesa-dri libopengl0" in line for line in told)
    assert any("apt-get install libosmesa6" in line for line in told)


@pytest.mark.usefixtures("no_libraries")
def test_without_opengl_all_sensors_but_cameras_work() -> None:
    simulation, camera = filming(ROOM)
    simulation.begin_tick(1)
    assert camera.due
    assert camera.delivered() is None
    simulation.step()
    simulation.close()


@needs_opengl
def test_opengl_serves_several_threads_one_after_another_and_at_once() -> None:
    simulations = [simulation_of(ROOM, size=(160, 120)) for _ in range(3)]
    seen: list[bytes] = []

    def look(simulation: Simulation) -> None:
        seen.append(camera_of(simulation).picture().rgb.tobytes())
        simulation.close()

    threads = [threading.Thread(target=look, args=(simulation,)) for simulation in simulations]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(seen) == 3
    assert len(set(seen)) == 1


@needs_opengl
def test_an_image_that_mujoco_cannot_draw_is_reported() -> None:
    camera = camera_of(simulation_of(ROOM, size=(40_000, 1)))
    with pytest.raises(RenderError, match="MuJoCo cannot draw"):
        camera.picture()


@needs_opengl
def test_after_a_failed_image_the_next_one_is_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise mujoco.FatalError("no")

    camera = camera_of(simulation_of(ROOM))
    before = camera.picture().rgb.tobytes()
    with monkeypatch.context() as patch:
        patch.setattr(mujoco, "mjr_render", refuse)
        with pytest.raises(RenderError, match="MuJoCo cannot draw: no"):
            camera.picture()
    assert camera.picture().rgb.tobytes() == before


@needs_opengl
def test_opengl_stays_open_over_an_exchange_of_the_model(monkeypatch: pytest.MonkeyPatch) -> None:
    opened, context = [], opengl.context

    def counted() -> AbstractContextManager[None]:
        opened.append(threading.current_thread().name)
        return context()

    monkeypatch.setattr(opengl, "context", counted)
    simulation = simulation_of(ROOM)
    camera_of(simulation).picture()
    model = mujoco.MjModel.from_xml_string('<mujoco><worldbody><geom size="1" pos="3 0 1"/></worldbody></mujoco>')
    simulation.rebind(model, mujoco.MjData(model))
    depth = camera_of(simulation).picture().depth
    assert depth[24, 32] == pytest.approx(2.0, abs=0.01)
    assert opened == ["render"]


@needs_opengl
@pytest.mark.skipif(not hasattr(os, "fork"), reason="there are no forks here")
@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_in_the_copy_that_a_fork_makes_a_picture_is_an_error_and_not_a_wait_for_ever() -> None:
    _, camera = filming(ROOM)
    camera.picture()
    child = os.fork()
    if child == 0:
        signal.alarm(30)
        told = ""
        with suppress(BaseException):
            try:
                camera.picture()
            except RenderError as error:
                told = str(error)
        os._exit("'spawn' or 'forkserver'" in told)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 1
    assert camera.picture().rgb.any()


@needs_opengl
def test_the_driver_reports_its_renderer_and_the_version_of_opengl() -> None:
    assert re.fullmatch(r"\S.*, [1-9]\.\d.*", opengl.driver())
