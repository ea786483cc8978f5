"""`graphrun snapshot`: render an image or a video of a scene or a recorded run."""

from __future__ import annotations

import argparse
import math
import re
import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

from graphengine.cli.common import add_file_arguments, clean, log_problem, open_scene, table
from graphengine.cli.options import add_flag, add_value
from graphengine.cli.progress import progress
from graphengine.format.errors import UsageError
from graphengine.format.files import near

if TYPE_CHECKING:
    from graphengine.cli.recorded_run import RecordedRun
    from graphengine.physics.simulation import Simulation
    from graphengine.runtime.session_core import SessionCore

    Advance = Callable[[float, Callable[[], bool]], None]
    """Function that runs for a duration, s, and calls a second function after each tick until that function returns False."""

OF_A_RUN = ("--scene", "--set", "--robot-state", "--localization", "--seed")
"""Options that change a run; they are illegal for a recording."""
DURATION = 10.0
"""Default duration of a video of a scene, s."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun snapshot` to its parser."""
    from graphengine.cli.quantities import duration, whole

    add_file_arguments(parser, recordings=True)
    parser.set_defaults(rays=None)
    where = "view: perspective (all robots), follow (behind the first robot), top, the name of a camera in the world's MJCF "
    where += "file, or the prim of a camera (default perspective)"
    add_value(parser, "--camera", "VIEW|PRIM", where, default="perspective")
    at = "simulation time of the image, or of the start of the video, such as 10 or 500ms (default 0)"
    add_value(parser, "--at", "TIME", at, type=duration, default=0.0)
    pixels = "size in pixels (default: that of the camera's prim, else 1280x720; for a video 640x360)"
    add_value(parser, "--size", "WxH", pixels, type=size)
    output = parser.add_mutually_exclusive_group(required=True)
    add_value(output, "--output", "FILE", "PNG file to write", short="-o", type=Path)
    add_value(output, "--video", "FILE", "video to write: a .webp, .gif or .mp4 file (.mp4 needs ffmpeg)", type=Path)
    how_long = "duration of the video in simulation time (default 10s, or up to the end of the recording)"
    add_value(parser, "--for", "TIME", how_long, dest="duration", type=duration)
    add_value(parser, "--fps", "N", "images of the video per second of simulation time (default 20)", type=whole)
    what = parser.add_mutually_exclusive_group()
    depth = "write a 16 bit depth image of a camera's prim: depth along its optical axis, mm; 0 if out of range"
    add_flag(what, "--depth", depth)
    add_flag(what, "--segmentation", "write an image with one colour per prim, and print the colours")


def size(text: str) -> tuple[int, int]:
    """Parse a size such as `1280x720` to width and height."""
    from graphengine.devices.camera import LARGEST_PICTURE as LARGEST

    match = re.fullmatch(r"([0-9]{1,5})x([0-9]{1,5})", text)
    width, height = (int(match[1]), int(match[2])) if match else (0, 0)
    if not (1 <= width <= LARGEST and 1 <= height <= LARGEST):
        raise argparse.ArgumentTypeError(f"{text!r} is not a size; write 1280x720, at most {LARGEST}x{LARGEST}")
    return width, height


def execute(arguments: argparse.Namespace) -> int:
    """Run the scene, or replay the recording, and write the image or video; return 0, or 1 if the scene has errors."""
    _check(arguments)
    if arguments.file.endswith(".mcap"):
        from graphengine.cli.recorded_run import start_recorded_run

        _check_recording_options(arguments)
        arguments.recording, arguments.against, arguments.seed = Path(arguments.file), None, None
        return start_recorded_run(arguments, lambda run: _take_recorded(arguments, run))
    from graphengine.api.run_options import RunOptions
    from graphengine.api.scene import loaded_of, start_runner

    arguments.rays = arguments.rays or "mujoco"  # hardly a ray is cast for an image, and compiling takes seconds
    scene = open_scene(arguments)
    if loaded_of(scene).world is None:
        path = loaded_of(scene).path
        raise UsageError(f"{path} is a graph without a scene and has nothing to draw; give a scene with --scene")
    with start_runner(scene, RunOptions(domain=0, log=log_problem)) as runner:

        def advance(seconds: float, on_tick: Callable[[], bool]) -> None:
            runner.run(seconds, math.inf, lambda _: on_tick())

        arguments.duration = DURATION if arguments.duration is None else arguments.duration
        return _take(arguments, runner.session, advance)


def _take_recorded(arguments: argparse.Namespace, run: RecordedRun) -> int:
    session = run.runner.session
    length = run.recording.length() * session.clock.delta
    rest = length - arguments.at
    if rest < 0.0:
        raise UsageError(f"--at {arguments.at:g}: the recording ends at t = {length:.3f} s")
    arguments.duration = rest if arguments.duration is None else min(arguments.duration, rest)
    return _take(arguments, session, RecordedTicks(run))


def _check(arguments: argparse.Namespace) -> None:
    """Raise UsageError if two options contradict each other."""
    from graphengine.api.video_encoders import check_path

    output: Path | None = arguments.output
    if output is not None and (output.suffix.lower() != ".png" or output.is_dir()):
        raise UsageError(f"-o {output}: write the name of a PNG file, such as snapshot.png; --video writes videos")
    for option, given in (("--for", arguments.duration), ("--fps", arguments.fps)):
        if output is not None and given is not None:
            raise UsageError(f"{option} is for videos; write the video with --video FILE instead of -o")
    if arguments.video is not None:
        if arguments.depth or arguments.segmentation:
            raise UsageError("--depth and --segmentation are for images; write one with -o instead of --video")
        check_path(arguments.video)


def _check_recording_options(arguments: argparse.Namespace) -> None:
    if given := [option for option in OF_A_RUN if getattr(arguments, option[2:].replace("-", "_"))]:
        raise UsageError(f"{given[0]}: a recording is shown with the options of the recorded run")


class RecordedTicks:
    """Replays a recording for a duration, as an `Advance`; warns if the replay differs from the recording."""

    def __init__(self, run: RecordedRun) -> None:
        from graphengine.recording.replay import Replay

        self._run = run
        self._replay = Replay(run.runner.session, run.runner.network, run.recording, warn=run.warn)
        self._ticks = run.recording.ticks()
        self._alike = True

    def __call__(self, seconds: float, on_tick: Callable[[], bool]) -> None:
        """Replay the next ticks; stop at the end of the recording."""
        for _ in range(round(seconds / self._run.runner.session.clock.delta)):
            tick = next(self._ticks, None)
            if tick is None or not (tick.whole or self._run.recording.failure):
                return
            error = self._replay.repeat(tick)
            found = self._replay.compare(tick, error) if self._alike else None
            if found is not None:
                self._alike = False
                self._run.warn(f"{found}; from this tick on, the replay is shown instead of the recorded run")
            if not on_tick() or error is not None:
                return


def _take(arguments: argparse.Namespace, session: SessionCore, advance: Advance) -> int:
    """Run a session until the time `--at`, and write an image or a video of its world."""
    from graphengine.api.pictures import find_camera, simulated

    world = simulated(session.services.world)
    try:
        prim = find_camera(world, arguments.camera)
    except UsageError as error:
        raise UsageError(f"--camera {error}") from None
    if arguments.depth and prim is None:
        raise UsageError(f"--depth: the view {arguments.camera} has no depth image; give --camera the prim of a camera")
    with progress("simulating", lambda: session.time, arguments.at):
        advance(arguments.at, lambda: True)
    return _take_video(arguments, session, world, advance) if arguments.video else _take_image(arguments, world)


def _take_image(arguments: argparse.Namespace, world: Simulation) -> int:
    from graphengine.api import pictures

    picture = pictures.look(world, arguments.camera, arguments.size, segmentation=arguments.segmentation)
    if arguments.depth:
        pictures.write_png(pictures.depth_in_millimetres(picture.depth), arguments.output)
    elif arguments.segmentation:
        assert picture.segmentation is not None
        pictures.write_png(pictures.segmentation_colours(picture.segmentation), arguments.output)
        legend = pictures.segmentation_legend(picture.segmentation, world.studio.labels)
        print(clean(table([(colour, f"{count} pixels", path) for colour, count, path in legend])))
    else:
        pictures.write_png(picture.rgb, arguments.output)
    height, width = picture.depth.shape
    _report(arguments.output, f"{arguments.camera} at t = {arguments.at:g} s, {width} x {height}")
    return 0


def _take_video(arguments: argparse.Namespace, session: SessionCore, world: Simulation, advance: Advance) -> int:
    from graphengine.api.video import FPS, Video

    fps = FPS if arguments.fps is None else arguments.fps
    delta = session.clock.delta
    video = Video(world, arguments.video, arguments.camera, arguments.duration, delta, arguments.size, fps)
    with closing(video):
        with progress("taking images", lambda: video.frames, video.planned):
            video.after_ticks(0)
            advance(arguments.duration, video.after_ticks)
        with progress(f"writing {near(str(video.path))}"):
            video.write()
        width, height = video.size
        shown = f"{arguments.camera} from t = {arguments.at:g} s, {video.frames / fps:g} s, {width} x {height}"
        _report(video.path, f"{shown}, {fps} images/s, {video.path.stat().st_size / 1e6:.2f} MB")
    return 0


def _report(path: Path, what: str) -> None:
    print(clean(f"{near(str(path))}: {what}"), file=sys.stderr)
