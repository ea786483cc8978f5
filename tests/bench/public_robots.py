"""Public robots by `graphrun new`, as tables: `python -m tests.bench.public_robots FOLDER [NAME …]`.

FOLDER holds clones of the repositories by their own names. Each description is imported with nothing but the arguments that its
vendor's launch file passes; no file is edited. tests/bench/base_figures.py measures bases, and `graphrun calibrate` their
odometry; tests/bench/arm_figures.py measures arms in a bent pose that the scene gives, and tests/bench/leg_figures.py legs.
`--write` renews the tables in docs/reference/robots.md.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from tests.bench.base_figures import outside
from tests.bench.public_descriptions import NEVER_TUNED_TO, ROBOTS, Robot

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/reference/robots.md"
BEGIN, END = "<!-- table: python -m tests.bench.public_robots FOLDER --write -->", "<!-- end of table -->"
LIMIT = 600.0
"""Seconds for one command."""


def graphrun(*arguments: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run the program in a folder to its end."""
    command = [sys.executable, "-m", "graphengine.cli", *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=LIMIT, check=False)


def measure(robot: Robot, clones: Path, folder: Path) -> dict[str, dict[str, Any]]:
    """Import a robot into a folder and measure its base and its arm; return the cells of its row in each table."""
    begin = time.perf_counter()
    project = robot.name.replace(" ", "_").replace("-", "_")
    arguments = [text.format(repository=clones / robot.folder) for text in robot.arguments]
    source = ["--from", str(clones / robot.folder / robot.file), "--package-path", str(clones)]
    made = graphrun("new", project, *source, *arguments, folder=folder)
    (folder / f"{project}.log").write_text(made.stdout + made.stderr)
    kind = "legs" if robot.legs else "arm" if robot.pose else "base"
    if made.returncode:
        return {kind: {"robot": robot.name, "result": f"not imported: {_first_error(made.stderr)}"}}
    scene = folder / project / f"{project}.yaml"
    _bend(scene, robot.pose)
    checked = graphrun("check", scene.name, "--strict", folder=scene.parent)
    (folder / f"{project}.check").write_text(checked.stdout + checked.stderr)
    row = {
        "robot": robot.name,
        "check": "clean" if checked.returncode == 0 else checked.stdout.strip().splitlines()[-1],
    }
    rows = {}
    if "graphs/base/" in (scene.parent / "robots" / scene.name).read_text(encoding="utf-8"):
        skid = "base: skid-steered" in made.stdout
        rows["base"] = row | _base(scene, folder / project, skid=skid)
    elif kind == "base":
        rows["base"] = row | {"result": f"not driven: {_last_remark(made.stdout, 'noticed: nothing moves')}"}
    if robot.pose:
        rows["arm"] = row | _arm(scene, robot.flange, folder / f"{project}.arm")
    if robot.legs:
        rows["legs"] = row | _legs(scene, folder / f"{project}.legs")
    seconds = f"{time.perf_counter() - begin:.0f}"
    return {name: cells | {"seconds": seconds} for name, cells in rows.items()}


def _last_remark(report: str, beginning: str) -> str:
    """What the report of an import says with such a beginning."""
    found = [line.partition(": ")[2].rpartition(" (")[0] for line in report.splitlines() if line.startswith(beginning)]
    return found[-1] if found else "no graph of a base"


def _bend(scene: Path, pose: dict[str, float]) -> None:
    """Let the robot of a new scene start in a pose."""
    if pose:
        starts = ", ".join(f"{joint}: {{start: {position}}}" for joint, position in pose.items())
        text = scene.read_text(encoding="utf-8")
        scene.write_text(
            text.replace("    robot_state:", f"    joints: {{{starts}}}\n    robot_state:"), encoding="utf-8"
        )


def _base(scene: Path, log: Path, *, skid: bool) -> dict[str, Any]:
    """How the base of a scene follows its commands."""
    done = graphrun("calibrate", scene.name, "--format", "json", folder=scene.parent)
    log.with_suffix(".calibrate").write_text(done.stdout + done.stderr)
    try:
        calibrated = json.loads(done.stdout)
    except ValueError:
        return {"result": f"not calibrated: {_first_error(done.stderr)}"}
    found = _figures("base_figures", [str(scene.resolve())], log.with_suffix(".figures"))
    if "result" in found:
        return found
    bad = outside(found, skid=skid)
    return {
        "kinematics": "skid-steered" if skid else calibrated["kinematics"] or "unknown",
        **{name: _cell(found.get(name)) for name in ("straight", "spot", "sideways", "slope_spot")},
        **{name: f"{_cell(found[name])}; {_cell(found[f'{name}_turn'])}" for name in ("arc_0.3", "arc_1.0")},
        "slope": f"{_cell(found['slope_up'])}; {_cell(found['slope_across'])}",
        "creep": f"{found['creep_across']:.1f}",
        "stop": f"{found['stop']:.2f}" if "stop" in found else "no limit",
        "odometry": _odometry(calibrated["odometry"]),
        "result": "in bounds" if not bad else f"out of bounds: {', '.join(NAMES[name] for name in bad)}",
    }


def _cell(share: float | list[float] | None) -> str:
    """Return shares as per cent, that of each direction."""
    if share is None:
        return "-"
    return " / ".join(
        "falls" if math.isnan(one) else f"{100 * one:.1f}" for one in (share if isinstance(share, list) else [share])
    )


BOUNDS = {"hold": 1.0, "points": 5.0, "end": 1.0, "points_payload": 10.0}
"""Largest errors of an arm, mrad."""


def _arm(scene: Path, flange: str, log: Path) -> dict[str, Any]:
    """How the arm of a scene holds its pose and follows trajectories."""
    found = _figures("arm_figures", [str(scene.resolve()), "--flange", flange], log)
    if "result" in found:
        return found
    good = all(found[name] <= bound for name, bound in BOUNDS.items()) and found["code"] == found["code_payload"] == 0
    return {
        "joints": found["joints"],
        **{name: f"{found[name]:.2f}" for name in ("hold", "points", "end", "hold_payload", "points_payload")},
        "goals": f"{sum(found['goals'].values())} of {len(found['goals'])}",
        "result": "in bounds" if good and all(found["goals"].values()) else "out of bounds",
    }


STANDING = 20.0
"""Largest change of the height of a robot on legs, mm."""


def _legs(scene: Path, log: Path) -> dict[str, Any]:
    """How the robot of a scene stands on its legs."""
    found = _figures("leg_figures", [str(scene.resolve())], log)
    if "result" in found:
        return found
    good = all(abs(found[kind]) <= STANDING and found[f"tilt_{kind}"] < 20.0 for kind in ("standing", "pushed"))
    return {
        "joints": found["joints"],
        **{kind: f"{found[kind]:+.1f} mm, {found[f'tilt_{kind}']:.1f} degrees" for kind in ("standing", "pushed")},
        "result": "in bounds" if good else "out of bounds",
    }


def _figures(module: str, arguments: list[str], log: Path) -> dict[str, Any]:
    """Run a module of this folder; return what it prints, or a result that says why it does not."""
    command = [sys.executable, "-m", f"tests.bench.{module}", *arguments]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=LIMIT, check=False)
    log.write_text(done.stdout + done.stderr)
    if done.returncode:
        return {"result": f"not measured: {done.stderr.strip().splitlines()[-1]}"}
    found = json.loads(done.stdout)
    assert isinstance(found, dict)
    return found


def _first_error(text: str) -> str:
    lines = [line for line in text.splitlines() if "error" in line] or text.splitlines() or ["no output"]
    return lines[0].rpartition("error ")[2]


def _odometry(found: list[dict[str, Any]]) -> str:
    """What the wheels' odometry errs by; ground truth is not shown."""
    wheels = [each for each in found if "ground_truth" not in each["topic"]]
    if not wheels or wheels[0]["distance_error"] is None:
        return "-"
    turn = wheels[0]["turn_error"]
    return f"{1000 * wheels[0]['distance_error']:.1f} mm/m" + (f", {turn:.3f} rad a turn" if turn is not None else "")


NAMES = {
    "straight": "straight",
    "sideways": "sideways",
    "arc_0.3": "speed in arcs at 0.3",
    "arc_1.0": "speed in arcs at the limits",
    "slope_up": "up the slope",
    "slope_across": "across the slope",
    "spot": "on the spot",
    "slope_spot": "on the spot on the slope",
    "arc_0.3_turn": "turn rate in arcs at 0.3",
    "arc_1.0_turn": "turn rate in arcs at the limits",
    "stop": "stop",
}
"""The figures of tests/bench/base_figures.py that have bounds, for people."""
BASES = {
    "robot": "robot",
    "kinematics": "kinematics",
    "straight": "straight, %",
    "spot": "on the spot, %",
    "sideways": "sideways, %",
    "arc_0.3": "arcs at 0.3 of the limits: speed; turn rate, %",
    "arc_1.0": "arcs at the limits: speed; turn rate, %",
    "slope": "5 degrees: up; across, %",
    "slope_spot": "5 degrees: on the spot, %",
    "creep": "parked across 5 degrees, mm/s",
    "stop": "way to stop from full speed, v²/2a",
    "odometry": "odometry error",
    "check": "`check --strict`",
    "result": "within the bounds above",
    "seconds": "import and test, s",
}
ARMS = {
    "robot": "robot",
    "joints": "joints",
    "hold": "hold, mrad",
    "points": "trajectory, mrad",
    "end": "end of trajectory, mrad",
    "hold_payload": "hold with 1 kg, mrad",
    "points_payload": "trajectory with 1 kg, mrad",
    "goals": "other goals passed",
    "check": "`check --strict`",
    "result": "within 1 (hold), 5 (trajectory), 1 (end), 10 mrad (trajectory with 1 kg)",
    "seconds": "import and test, s",
}
LEGS = {
    "robot": "robot",
    "joints": "joints",
    "standing": "after 10 s: change of height, tilt",
    "pushed": "10 s after a push of 50 N for 0.1 s",
    "check": "`check --strict`",
    "result": "within 20 mm, 20 degrees",
    "seconds": "import and test, s",
}
TABLES = {"base": BASES, "arm": ARMS, "legs": LEGS}


def table(columns: dict[str, str], rows: list[dict[str, Any]]) -> str:
    """Return rows as a Markdown table."""
    lines = ["| " + " | ".join(columns.values()) + " |", "|" + "---|" * len(columns)]
    lines += ["| " + " | ".join(str(row.get(column, "-")) for column in columns) + " |" for row in rows]
    return "\n".join(lines)


def main() -> None:
    """Measure the robots and print, or write, the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--keep", type=Path, help="folder for the projects and their logs")
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    known = (*ROBOTS, *NEVER_TUNED_TO)
    present = [robot for robot in known if (given.folder / robot.folder).is_dir()]
    chosen = [
        robot for robot in present if not given.names or any(n.lower() in robot.name.lower() for n in given.names)
    ]
    with tempfile.TemporaryDirectory() as scratch, ThreadPoolExecutor(2) as pool:
        folder = given.keep or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        rows = list(pool.map(lambda robot: measure(robot, given.folder.resolve(), folder), chosen))
    of_kind = {kind: [row[kind] for row in rows if kind in row] for kind in TABLES}
    text = "\n\n".join(table(TABLES[kind], found) for kind, found in of_kind.items() if found)
    print(text)
    if given.write:
        page = PAGE.read_text(encoding="utf-8")
        head, tail = page.partition(BEGIN)[0], page.partition(END)[2]
        PAGE.write_text(f"{head}{BEGIN}\n\n{text}\n\n{END}{tail}", encoding="utf-8")


if __name__ == "__main__":
    main()
