"""`graphrun snapshot --video`: of a scene, and of a recording, which is replayed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from graphengine.api import video
from graphengine.scene.loaded_scene import Options
from tests.cli.harness import Graphrun
from tests.physics.pictures.harness import needs_opengl
from tests.recording.harness import NOISY_ROBOT, NOISY_SCENE, put, record, rewritten

SCENE, SMALL = "dd100_flat", ("--size", "48x32")


@pytest.fixture(autouse=True)
def _coarse_shadows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fine ones take most of the time where there is no GPU."""
    monkeypatch.setattr(video, "SHADOW_MAP", 64)


def last_frame(path: Path) -> NDArray[np.float64]:
    with Image.open(path) as film:
        film.seek(film.n_frames - 1)  # type: ignore[attr-defined]
        return np.asarray(film.convert("RGB"), float)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A robot that drives for a second."""
    path = tmp_path_factory.mktemp("recording") / "out.mcap"
    record(path, 60, SCENE, commands={1: [(1.0, 1.5)]})
    return path


@needs_opengl
def test_a_video_has_the_given_start_and_duration(graphrun: Graphrun, project: Path) -> None:
    times = ["--at", "100ms", "--for", "500ms", "--fps", "10", "--camera", "follow"]
    result = graphrun("snapshot", SCENE, "--video", "film.webp", *times, *SMALL, code=0, out="")
    told = "film.webp: follow from t = 0.1 s, 0.5 s, 48 x 32, 10 images/s, 0.00 MB"
    assert result.err.splitlines()[-1] == told
    with Image.open(project / "film.webp") as film:
        assert (film.size, film.format) == ((48, 32), "WEBP")
    assert sorted(path.name for path in project.iterdir()) == ["film.webp", "mine.yaml"]


@needs_opengl
def test_a_recording_is_rendered_from_the_given_time(graphrun: Graphrun, project: Path, recording: Path) -> None:
    film = ["--video", "film.webp", "--at", "700ms", "--fps", "10", "--camera", "top"]
    result = graphrun("snapshot", str(recording), *film, *SMALL, code=0, out="")
    assert result.err.splitlines()[-1].startswith("film.webp: top from t = 0.7 s, 0.3 s, 48 x 32, 10 images/s")
    assert "differ" not in result.err
    graphrun("snapshot", str(recording), "--at", "900ms", "--camera", "top", *SMALL, "-o", "late.png", code=0)
    graphrun("snapshot", SCENE, "--at", "900ms", "--camera", "top", *SMALL, "-o", "unmoved.png", code=0)
    late, unmoved = (np.asarray(Image.open(project / f"{name}.png"), float) for name in ("late", "unmoved"))
    film_end = last_frame(project / "film.webp")
    assert np.abs(film_end - late).mean() < np.abs(film_end - unmoved).mean()  # WebP loses something
    assert np.abs(late - unmoved).max() > 50.0


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["-o", "p.png", "--for", "1s"], "--for is for videos; write the video with --video FILE instead of -o"),
        (["-o", "p.png", "--fps", "5"], "--fps is for videos"),
        (["-o", "p.png", "--video", "film.gif"], "not allowed with argument"),
        (["--video", "film.gif", "--depth"], "--depth and --segmentation are for images"),
        (
            ["--video", "film.png"],
            "film.png: write the name of a video file, such as video.webp\n  formats: .gif, .mp4",
        ),
        (["--video", "film.gif", "--fps", "61"], "fps: expected 1 to 60 images per second, got 61"),
        (["--video", "film.gif", "--for", "1000min"], "1200000 images of 640 x 360 pixels are too large for a video"),
    ],
)
def test_options_that_do_not_fit_are_refused(
    graphrun: Graphrun, project: Path, arguments: list[str], told: str
) -> None:
    assert told in graphrun("snapshot", SCENE, *arguments, code=2).err
    assert not (project / "film.gif").exists()


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--seed", "3"], "--seed: a recording is shown with the options of the recorded run"),
        (["--at", "5s"], "--at 5: the recording ends at t = 1.000 s"),
    ],
)
def test_options_of_a_run_are_refused_for_a_recording(
    graphrun: Graphrun, project: Path, recording: Path, arguments: list[str], told: str
) -> None:
    assert told in graphrun("snapshot", str(recording), *arguments, "-o", "p.png", code=2).err


@needs_opengl
def test_a_recording_that_replays_differently_is_shown_with_a_warning(graphrun: Graphrun, project: Path) -> None:
    put(project / "hall" / "noisy_robot.yaml", NOISY_ROBOT)
    record(project / "out.mcap", 5, put(project / "hall" / "scene.yaml", NOISY_SCENE), options=Options(seed=7))
    changed = rewritten(project / "out.mcap", manifest={"seed": "8"})
    result = graphrun("snapshot", str(changed), "--at", "50ms", *SMALL, "-o", "picture.png", code=0)
    warning = "warning: different in tick 1, t = 0.016667 s: /dd100_0000/sim_lidar/scan; from this tick on, the replay is shown"
    assert result.err.count("different in tick") == 1
    assert warning in result.err
