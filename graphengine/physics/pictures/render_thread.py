"""Renders the frames of all cameras of a simulation in one thread, in the order in which they were captured.

An OpenGL context belongs to one thread. The render thread creates its context for the first image, and destroys it when the
`RenderThread` is closed or garbage-collected.
"""

from __future__ import annotations

import os
import threading
import weakref
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from contextlib import closing, suppress
from dataclasses import dataclass
from queue import SimpleQueue
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from graphengine.descriptions.engine import body_names, mujoco
from graphengine.devices.camera import Picture
from graphengine.devices.rotation import Pose
from graphengine.devices.stage import housing_of
from graphengine.format.stateful import Stateful
from graphengine.physics.pictures.bounding_boxes import BoundingBoxes
from graphengine.physics.pictures.frame_capture import FrameCapture, Lens, Shot
from graphengine.physics.pictures.rendering import Image, RendererCache

if TYPE_CHECKING:
    from graphengine.physics.core.simulation_core import SimulationCore

NICENESS = 10
"""Niceness of the render thread. It gives priority to the thread that steps the simulation."""


@dataclass(frozen=True, slots=True)
class _Job:
    shot: Shot
    develop: Callable[[Image], Picture]
    picture: Future[Picture]
    give_back: Callable[[Shot], None]
    size: tuple[int, int]
    """Smallest image size that a new renderer must support (`far`: smallest far distance), because later jobs may need it."""
    far: float


_Jobs = SimpleQueue[_Job | None]


class RenderThread(Stateful):
    """Captures frames in the thread that steps the simulation, and renders them in a second thread."""

    kept = ("_labels", "_numbers")

    def __init__(self, simulation: SimulationCore) -> None:
        self._simulation = simulation
        self._captures: FrameCapture | None = None
        self._solids: BoundingBoxes | None = None
        self._numbers: dict[str, int] = {}
        self._labels: dict[int, str] = {}
        self._size, self._far = (1, 1), 1.0
        self._jobs: _Jobs | None = None
        self._thread: threading.Thread | None = None
        self._end: Callable[[], object] = lambda: None

    @property
    def labels(self) -> Mapping[int, str]:
        """Prim path of each segmentation ID; the ID of a prim never changes."""
        self._present()
        return self._labels

    def expect(self, lens: Lens) -> None:
        """Announce a lens. The first renderer is then made large enough for the images of this lens."""
        self._size = max(self._size[0], lens.size[0]), max(self._size[1], lens.size[1])
        self._far = max(self._far, lens.far)

    def capture(self, pose: Pose, lens: Lens, *, segmentation: bool = False, whole: bool = False) -> Shot:
        """Capture what a camera at a pose sees in the current state; see `FrameCapture.capture`."""
        return self._present().capture(self._simulation.data, pose, lens, segmentation=segmentation, whole=whole)

    def boxes(self, pose: Pose) -> NDArray[np.void]:
        """Return the bounding boxes of all prims with a segmentation ID in the optical frame of a camera at a pose."""
        self._present()
        if self._solids is None:
            self._solids = BoundingBoxes(self._simulation.model, self._prims_of_bodies(self._simulation.model))
        return self._solids.seen_from(self._simulation.data, pose)

    def draw(self, shot: Shot, develop: Callable[[Image], Picture]) -> Future[Picture]:
        """Queue a shot for rendering, and return the future image.

        Args:
            shot: captured frame.
            develop: function that the render thread calls to make the camera's output from the rendered image.
        """
        self.expect(shot.lens)
        picture: Future[Picture] = Future()
        self._open_jobs().put(_Job(shot, develop, picture, self._present().give_back, self._size, self._far))
        return picture

    def _open_jobs(self) -> _Jobs:
        """Return the render thread's job queue; start the thread at first use, and again in a forked process."""
        if self._jobs is None or self._thread is None or not self._thread.is_alive():
            self._jobs = SimpleQueue()
            self._thread = threading.Thread(target=_draw_all, args=(self._jobs,), name="render", daemon=True)
            self._thread.start()
            self._end = weakref.finalize(self, _finish, self._jobs, self._thread)
        return self._jobs

    def close(self) -> None:
        """Finish pending jobs and end the render thread. Repeated calls do nothing; a later job starts a new thread."""
        self._end()
        self._jobs = None

    def _present(self) -> FrameCapture:
        """Return the `FrameCapture` for the simulation's current model; create it if the model has changed."""
        model = self._simulation.model
        if self._captures is None or self._captures.model is not model:
            self._captures, self._solids = FrameCapture(model, self._prims_of_bodies(model)), None
        return self._captures

    def _prims_of_bodies(self, model: mujoco.MjModel) -> NDArray[np.int32]:
        """Return the segmentation ID of each body; a body without a prim has the ID of its parent body."""
        paths = {prim.body or housing_of(prim): prim.path for prim in self._simulation.stage.prims()}
        numbers = np.zeros(model.nbody, np.int32)
        numbers[0] = self._number("/World")
        for body, name in enumerate(body_names(model)[1:], 1):
            path = paths.get(name)
            numbers[body] = self._number(path) if path else numbers[model.body_parentid[body]]
        return numbers

    def _number(self, path: str) -> int:
        number = self._numbers.setdefault(path, len(self._numbers) + 1)
        self._labels[number] = path
        return number


def _finish(jobs: _Jobs, thread: threading.Thread) -> None:
    jobs.put(None)
    if thread is not threading.current_thread():  # where the garbage collector happened to run
        thread.join()


def _draw_all(jobs: _Jobs) -> None:
    """Run the render thread: render the jobs in the queue until None arrives."""
    with suppress(OSError):  # a matter of the thread, and of those that the driver starts from it
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), NICENESS)
    with closing(RendererCache()) as renderers:
        while (job := jobs.get()) is not None:
            if job.picture.set_running_or_notify_cancel():
                try:
                    job.picture.set_result(job.develop(renderers.draw(job.shot, job.size, job.far)))
                except BaseException as error:  # told to whoever waits for the picture
                    job.picture.set_exception(error)
            job.give_back(job.shot)
            del job  # or this thread would keep the simulation alive
