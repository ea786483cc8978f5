"""`--bad-values`: messages about dropped values, and replays of recordings made before the option existed."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from mcap.reader import make_reader

import graphengine as ge
from tests.cli.harness import Graphrun, live
from tests.recording.harness import DIVIDES

MEMORY = ("--transport", "memory")
RECORDINGS = Path(__file__).parent / "recordings"


@pytest.fixture
def divides(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))  # where no run of others is found
    Path("divides.yaml").write_text(DIVIDES, encoding="utf-8")
    return "divides.yaml"


def metadata(path: str) -> dict[str, str]:
    """All that a recording says of its run."""
    with Path(path).open("rb") as file:
        return {key: value for item in make_reader(file).iter_metadata() for key, value in item.metadata.items()}


def test_a_bad_value_is_dropped_with_a_warning_and_counted_in_the_summary(graphrun: Graphrun, divides: str) -> None:
    result = graphrun("run", divides, *MEMORY, "--for", "1s", "--record", "out.mcap", code=0)
    warning = "warning: /World/divides/Ratio: b must be other than 0, it is 0.0; dropped at tick 5\n  divides.yaml:5:3:"
    assert result.err.count(warning) == 1
    assert "dropped bad values: in 1 tick at /World/divides/Ratio\n" in result.err
    made = metadata("out.mcap")
    assert json.loads(made["bad_values"]) == "drop"
    assert json.loads(made["dropped_values"]) == {"/World/divides/Ratio": 1}
    assert graphrun("replay", "out.mcap").out.startswith("identical: 60 messages in 60 ticks")


def test_a_bad_value_ends_the_run_with_the_option_stop(graphrun: Graphrun, divides: str) -> None:
    result = graphrun("run", divides, *MEMORY, "--for", "1s", "--record", "out.mcap", "--bad-values", "stop", code=1)
    assert "error: divides.yaml:5:3: node Ratio (omni.graph.nodes.Divide) raised BadValueError: b must be" in result.err
    assert json.loads(metadata("out.mcap")["bad_values"]) == "stop"
    assert graphrun("replay", "out.mcap").out == "identical: 4 messages in 4 ticks, 0.067 s\n"


@pytest.mark.parametrize(
    ("name", "verdict"),
    [
        ("divides", "identical: 4 messages in 4 ticks, 0.067 s\n"),  # ended by a division by zero
        (
            "pushes",
            "identical: 6 messages in 6 ticks, 0.100 s\n",
        ),  # ended by an effort of 1e5 N m, which nothing clamped
    ],
)
def test_recordings_from_before_bad_values_were_dropped_end_as_they_did(
    graphrun: Graphrun, name: str, verdict: str
) -> None:
    result = graphrun("replay", str(RECORDINGS / f"{name}.mcap"))
    assert (result.code, result.out) == (0, verdict)


def test_a_recording_with_values_that_are_refused_today_is_replayed_with_warnings(graphrun: Graphrun) -> None:
    result = graphrun("replay", str(RECORDINGS / "limits.mcap"))
    # Its graph has a radius of -0.1 m; a limit was set to -1, then the radius to 0, which ended the run.
    assert (result.code, result.out) == (0, "identical: 6 messages in 6 ticks, 0.100 s\n")
    first, *_ = warned = [line for line in result.err.splitlines() if "warning W109" in line]
    assert len(warned) == 2
    assert first.endswith(
        "limits.yaml:8:27: warning W109: Controller.wheelRadius: expected a value > 0, got -0.1 (unit: m)"
    )


def test_a_value_that_was_set_and_dropped_is_dropped_in_a_replay(graphrun: Graphrun, tmp_path: Path) -> None:
    path = tmp_path / "out.mcap"
    with ge.load("dd100_flat").session(record=path) as sim:
        sim.step(3)
        sim.set("ArtController.effortCommand", [1.0, 2.0, 3.0])
        sim.step(3)
    made = metadata(str(path))
    assert json.loads(made["drops_set_values"]) is True
    assert list(json.loads(made["dropped_values"]).values()) == [3]
    assert graphrun("replay", str(path)).out.startswith("identical: ")


def test_ctl_state_shows_dropped_values(graphrun: Graphrun, divides: str, tmp_path: Path) -> None:
    with live("run", divides, *MEMORY, "--rate", "1", cwd=tmp_path) as run:
        assert run.hear(lambda line: "dropped at tick 5" in line)
        shown = graphrun("ctl", "state")
        assert "dropped bad values: in 1 tick at /World/divides/Ratio" in shown.out
        assert json.loads(graphrun("ctl", "state", "--json").out)["dropped_values"] == {"/World/divides/Ratio": 1}
        assert re.search(r": playing, t = ", shown.out)
