"""`graphrun data`: topics and ports of recordings and bags as tables."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import graphengine as ge
from graphengine.format.errors import UsageError
from tests.api.expectations.bag_writing import LEVEL, made, write_bag
from tests.cli.harness import Graphrun

ODOM = "/dd100_0000/odom"
POSITION = "dd100/joint_states/ComputeOdom.position"


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, np.ndarray[Any, Any]]:
    """A recording of a robot that drives for a second, and the values of a port that Python has read meanwhile."""
    path = tmp_path_factory.mktemp("data") / "out.mcap"
    with ge.load("dd100_flat", rays="mujoco").session(record=path, ports=["ComputeOdom.position"]) as sim:
        record = sim.record_values(POSITION)
        sim.publish("/dd100_0000/cmd_vel", {"linear": {"x": 0.5}}, every=0.1)
        sim.run(1.0)
        return path, record[POSITION]


def rows(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


def test_a_topic_has_a_column_for_each_number_and_a_row_for_each_time(graphrun: Graphrun, recording: Any) -> None:
    path, positions = recording
    table = rows(graphrun("data", str(path), "--topics", ODOM, code=0).out)
    assert [float(row["time"]) for row in table] == pytest.approx([tick / 60 for tick in range(1, 61)], abs=1e-9)
    assert [float(row[f"{ODOM}.pose.pose.position.x"]) for row in table] == pytest.approx(list(positions[:, 0]))
    assert table[0][f"{ODOM}.header.frame_id"] == "odom"
    assert f"{ODOM}.pose.covariance[35]" in table[0]


def test_a_field_selects_the_columns_below_it(graphrun: Graphrun, recording: Any) -> None:
    done = graphrun("data", str(recording[0]), "--topics", f"{ODOM}.twist.twist.linear", code=0)
    assert done.lines[0] == ",".join(("time", *(f"{ODOM}.twist.twist.linear.{axis}" for axis in "xyz")))


def test_a_recorded_port_has_its_values_to_the_last_digit(graphrun: Graphrun, recording: Any) -> None:
    path, positions = recording
    table = rows(graphrun("data", str(path), "--ports", "*/ComputeOdom.position", code=0).out)
    read = [[float(row[f"{POSITION}[{axis}]"]) for axis in range(3)] for row in table]
    assert read == positions.tolist()


def test_a_port_that_was_not_recorded_is_computed_by_a_replay(graphrun: Graphrun, recording: Any) -> None:
    path, _ = recording
    words = (
        "--topics",
        f"{ODOM}.pose.pose.position.x",
        "--ports",
        "DiffController.previousLinear",
        "ComputeOdom.position",
    )
    table = rows(graphrun("data", str(path), *words, code=0).out)
    assert len(table) == 60
    assert float(table[-1]["dd100/cmd_vel/DiffController.previousLinear"]) == 0.5
    assert all(row[f"{POSITION}[0]"] == row[f"{ODOM}.pose.pose.position.x"] for row in table)


def test_the_value_of_a_port_stands_until_it_changes(graphrun: Graphrun, recording: Any) -> None:
    table = rows(
        graphrun("data", str(recording[0]), "--ports", "ComputeOdom.position", "DiffController.wheelRadius").out
    )
    assert {row["dd100/cmd_vel/DiffController.wheelRadius"] for row in table} == {"0.049"}


def test_topics_of_other_rates_leave_cells_empty(graphrun: Graphrun, recording: Any) -> None:
    path, scan = recording[0], "/dd100_0000/sim_lidar/scan.range_max"
    table = rows(graphrun("data", str(path), "--topics", scan, "/clock.clock.sec", code=0).out)
    assert len(table) == 60
    assert sum(row[scan] != "" for row in table) == 21  # 20 Hz, and one at the start


def test_parquet_has_the_numbers_of_the_csv(graphrun: Graphrun, recording: Any, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    for name in ("out.csv", "out.parquet"):
        graphrun("data", str(recording[0]), "--topics", ODOM, "-o", str(tmp_path / name), code=0)
    table = parquet.read_table(tmp_path / "out.parquet").to_pylist()
    read = rows((tmp_path / "out.csv").read_text(encoding="utf-8"))
    assert [{name: str(value) for name, value in row.items()} for row in table] == read


def test_a_bag_of_another_program_begins_at_time_0(graphrun: Graphrun, tmp_path: Path) -> None:
    unit = made("acme_msgs/msg/Unit", name="m")
    path = write_bag(tmp_path / "bag", [(at, "/level", made(LEVEL, level=at / 2, unit=unit)) for at in (0.0, 0.5, 1.0)])
    table = rows(graphrun("data", str(path), "--topics", "/level", code=0).out)
    assert [tuple(row.values()) for row in table] == [("0.0", "0.0", "m"), ("0.5", "0.25", "m"), ("1.0", "0.5", "m")]


def test_messages_of_a_topic_with_the_same_time_have_a_row_each(graphrun: Graphrun, tmp_path: Path) -> None:
    unit = made("acme_msgs/msg/Unit", name="m")
    times = (0.0, 0.5, 0.5, 1.0)
    path = write_bag(tmp_path / "bag", [(at, "/level", made(LEVEL, level=i, unit=unit)) for i, at in enumerate(times)])
    table = rows(graphrun("data", str(path), "--topics", "/level.level", code=0).out)
    assert [(float(row["time"]), float(row["/level.level"])) for row in table] == list(
        zip(times, range(4), strict=True)
    )


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((), "choose topics with --topics, or ports with --ports"),
        (("--topics", "/odm"), "no topic '/odm'"),
        (("--topics", f"{ODOM}.pose.pse"), f"{ODOM}: no field 'pse' in 'pose.pse'"),
        (("--ports", "ComputeOdom.positoin"), "IsaacComputeOdometry has no port with a value 'positoin'"),
        (("--topics", ODOM, "-o", "out.xls"), "out.xls"),
    ],
)
def test_a_mistake_is_one_line_with_the_remedy(graphrun: Graphrun, recording: Any, words: Any, message: str) -> None:
    done = graphrun("data", str(recording[0]), *words, code=2)
    assert message in done.err
    assert "Traceback" not in done.err


def test_a_file_that_is_no_recording_is_an_error(graphrun: Graphrun, tmp_path: Path) -> None:
    (tmp_path / "x.mcap").write_text("no bag", encoding="utf-8")
    assert "x.mcap: " in graphrun("data", str(tmp_path / "x.mcap"), "--topics", "/a", code=1).err


def test_an_existing_file_is_replaced_only_by_a_whole_table(graphrun: Graphrun, recording: Any, tmp_path: Path) -> None:
    path = tmp_path / "out.csv"
    path.write_text("mine", encoding="utf-8")
    graphrun("data", str(recording[0]), "--topics", "/odm", "-o", str(path), code=2)
    assert path.read_text(encoding="utf-8") == "mine"
    graphrun("data", str(recording[0]), "--topics", "/clock", "-o", str(path), code=0)
    assert path.read_text(encoding="utf-8").startswith("time,/clock.clock.sec")


def test_ports_of_a_run_need_a_recording_or_foxglove(graphrun: Graphrun) -> None:
    done = graphrun("run", "dd100_flat", "--ports", "*.position", code=2)
    assert "--ports needs --record FILE or --foxglove [HOST:]PORT" in done.err


def test_a_record_ends_with_a_reload(tmp_path: Path) -> None:
    path = tmp_path / "g.yaml"
    path.write_text("graph: g\nnodes: {Tick: OnPlaybackTick}\n", encoding="utf-8")
    with ge.load(path).session() as sim:
        record = sim.record_values("Tick.frame")
        sim.step(3)
        path.write_text("graph: g\nnodes: {Tick: OnPlaybackTick, Other: OnPlaybackTick}\n", encoding="utf-8")
        sim.reload()
        sim.step(3)
        assert record["g/Tick.frame"].tolist() == [1, 2, 3]
        assert record.times.tolist() == pytest.approx([tick / 60 for tick in (1, 2, 3)])
        with pytest.raises(UsageError, match=r"no port"):
            sim.record_values("Tick.nothing")
