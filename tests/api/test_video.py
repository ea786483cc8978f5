"""`Session.video`: what the files contain, and what is refused before the run."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest import mock

import numpy as np
import pytest
from PIL import Image, ImageSequence

import graphengine as ge
from graphengine.api import video, video_encoders
from graphengine.api.video_encoders import Film
from tests.other_process import in_another_process
from tests.physics.pictures.harness import needs_opengl

SIZE = (48, 32)


@pytest.fixture(scope="module")
def scene() -> ge.Scene:
    return ge.load("dd100_flat", rays="mujoco")


def filmed(path: Path) -> bytes:
    """A video of a robot that drives, with coarse shadows, because fine ones take most of the time where there is no GPU."""
    with mock.patch.object(video, "SHADOW_MAP", 64), ge.load("dd100_flat", rays="mujoco").session() as sim:
        sim.publish("/dd100_0000/cmd_vel", {"linear": {"x": 1.0}, "angular": {"z": 1.0}}, every=0.1)
        assert sim.video(path, 0.5, "follow", SIZE, 10)
        assert sim.time == 0.5
    return path.read_bytes()


@needs_opengl
@pytest.mark.parametrize("suffix", ["webp", "gif"])
def test_a_video_shows_the_run_at_its_speed_and_is_alike_each_time(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"drive.{suffix}"
    content = filmed(path)
    with Image.open(path) as made:
        assert (made.format, made.size, made.info["loop"]) == (suffix.upper(), SIZE, 0)
        frames, lasting = [], []
        for frame in ImageSequence.Iterator(made):
            frame.load()
            lasting.append(frame.info["duration"])
            frames.append(np.asarray(frame.convert("RGB"), float))
    assert lasting == [100] * 5
    assert np.abs(frames[-1] - frames[0]).mean() > 2.0
    assert [left.name for left in tmp_path.iterdir()] == [path.name]
    again = tmp_path / f"again.{suffix}"
    assert (in_another_process(filmed, again) if suffix == "webp" else filmed(again)) == content


@needs_opengl
def test_a_fixed_camera_and_a_camera_of_the_robot_film_too(scene: ge.Scene, tmp_path: Path) -> None:
    for camera, size in (("top", SIZE), ("Camera_Pseudo_Depth", (64, 40))):
        with scene.session() as sim:
            sim.video(tmp_path / "film.webp", 0.2, camera, size, 10)
        with Image.open(tmp_path / "film.webp") as made:
            assert made.size == size


@needs_opengl
def test_a_run_that_is_interrupted_ends_the_video(scene: ge.Scene, tmp_path: Path) -> None:
    with scene.session() as sim:
        sim.interrupt()
        assert not sim.video(tmp_path / "film.webp", 0.5, size=SIZE)
    with Image.open(tmp_path / "film.webp") as made:
        assert made.size == SIZE


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("film.avi", 1.0), "film.avi: write the name of a video file, such as video.webp"),
        (("film.webp", 0.0), "seconds: expected a duration of more than 0 s, got 0.0"),
        (("film.webp", float("inf")), "seconds: expected a duration of more than 0 s, got inf"),
        (("film.webp", 1.0, "follow", None, 0), "fps: expected 1 to 60 images per second, got 0"),
        (("film.webp", 1e4), "200000 images of 640 x 360 pixels are too large for a video\n  make it shorter"),
        (("film.webp", 1.0, "folow"), "folow: there is no view or camera with this name or path"),
    ],
)
def test_what_makes_no_video_is_refused_before_the_run(
    scene: ge.Scene, tmp_path: Path, arguments: tuple[str, float], told: str
) -> None:
    name, *rest = arguments
    with scene.session() as sim:
        with pytest.raises(ge.UsageError) as refused:
            sim.video(tmp_path / name, *rest)  # type: ignore[arg-type]
        assert told in str(refused.value)
        assert sim.tick == 0
    assert not any(tmp_path.iterdir())


@contextmanager
def film_of(folder: Path, count: int) -> Iterator[Film]:
    """Images of which each has one grey."""
    raw = folder / "film.raw"
    raw.write_bytes(b"".join(bytes([10 * index]) * (3 * SIZE[0] * SIZE[1]) for index in range(count)))
    with raw.open("rb") as file:
        yield Film(file, SIZE)


def test_roundings_of_durations_do_not_add_up(tmp_path: Path) -> None:
    with film_of(tmp_path, 12) as film:
        assert film.durations(30, 10) == [30, 40, 30] * 4  # a GIF counts hundredths of a second
        assert sum(film.durations(24, 1)) == 500
        assert [film.tell(), film.n_frames] == [0, 12]


def test_mp4_without_ffmpeg_is_refused_with_the_package_to_install(
    scene: ge.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with scene.session() as sim, pytest.raises(ge.UsageError, match="apt-get install ffmpeg"):
        sim.video(tmp_path / "film.mp4", 1.0)


def stand_in(folder: Path, script: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A program `ffmpeg` that is a shell script."""
    program = folder / "ffmpeg"
    program.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", f"{folder}{os.pathsep}{os.environ['PATH']}")


def test_ffmpeg_reads_all_images_and_its_file_is_taken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stand_in(tmp_path, 'for last; do :; done; cat > "$last"; echo "$@" > "$0.called"', monkeypatch)
    with film_of(tmp_path, 3) as film:
        film.seek(2)
        made = video_encoders.ENCODERS[".mp4"](film, 25)
    assert made == (tmp_path / "film.raw").read_bytes()
    assert "-s 48x32 -r 25 -i -" in (tmp_path / "ffmpeg.called").read_text()


def test_what_ffmpeg_complains_about_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stand_in(tmp_path, "echo no such encoder >&2; exit 3", monkeypatch)
    with film_of(tmp_path, 3) as film, pytest.raises(ge.RenderError, match="ffmpeg failed: no such encoder"):
        video_encoders.ENCODERS[".mp4"](film, 25)


def test_a_film_is_as_long_as_its_time() -> None:
    assert video.check_length(10.0, 20, SIZE) == 200
    assert video.check_length(0.1 + 0.2, 10, SIZE) == 3
    assert video.check_length(0.01, 10, SIZE) == 1
