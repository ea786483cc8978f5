"""The page docs/reference/interop.md, made whole from the results of the interop matrix."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from importlib.metadata import version
from pathlib import Path
from xml.etree import ElementTree

from graphengine.messages.distros import DISTROS
from tests.interop import distros
from tests.interop.cells import COLUMNS, HINT, MAY_FAIL, ROWS
from tests.interop.result import Result

PAGE = Path(__file__).resolve().parents[2] / "docs/reference/interop.md"
DISTROS_TITLE = "## Message definitions"
_NAMES = {"dds": "embedded DDS", "rclpy": "`--transport rclpy`"}
_RMWS = ("rmw_cyclonedds_cpp", "rmw_fastrtps_cpp")
_LIBRARIES = {
    "Cyclone DDS": "lib/cmake/CycloneDDS/CycloneDDSConfigVersion.cmake",
    "Fast DDS": "share/fastrtps/cmake/fastrtps-config-version.cmake",
}
_NO, _YES = "no", "yes"


def render(results: Sequence[Result]) -> str:
    """Return the page.

    Raises:
        ValueError: a cell has no result.
    """
    cells = {(result.row, result.kind, result.rmw): result for result in results}
    if absent := [(row, *column) for row in ROWS for column in COLUMNS if (row, *column) not in cells]:
        raise ValueError(f"cells without a result: {absent}")
    return "\n".join([*_head(), *_summary(cells), *_unreachable(), *_figures(cells), *_versions(), *_distros()]) + "\n"


def distros_section() -> str:
    """Return the part of the page on message definitions, which needs no ROS 2."""
    return "\n".join(_distros()) + "\n"


def packages() -> dict[str, str]:
    """Return the versions of the ROS 2 packages in the sourced workspaces."""
    found: dict[str, str] = {}
    for prefix in filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)):
        for manifest in sorted(Path(prefix).glob("share/*/package.xml")):
            found.setdefault(manifest.parent.name, ElementTree.parse(manifest).findtext("version", ""))
    return found


def _head() -> Iterator[str]:
    yield """# Interoperability with ROS 2

Each cell was run between this project and a node of rclpy in another process. A row names what this project does: in
`service server` it offers the service and a ROS 2 node calls it. The columns are its transport and the RMW of the ROS 2 node.
Embedded DDS needs no installed ROS 2; `--transport rclpy` uses the one that is sourced. `python -m tests.interop.matrix` writes
this page where a ROS 2 is sourced; `tests/interop/test_matrix.py` fails if another cell fails, and also if one of those that
fail here begins to work.
"""


def _summary(cells: dict[tuple[str, str, str], Result]) -> Iterator[str]:
    yield "| | " + " | ".join(f"{_NAMES[kind]}, {rmw}" for kind, rmw in COLUMNS) + " |"
    yield "|---|" + "---|" * len(COLUMNS)
    for row in ROWS:
        yield f"| {row} | " + " | ".join(_YES if cells[row, *column].works else _NO for column in COLUMNS) + " |"


def _unreachable() -> Iterator[str]:
    rows = [row for row in ROWS if (row, *COLUMNS[1]) in MAY_FAIL]
    yield f"""
## What does not work

Between embedded DDS, which is Cyclone DDS, and nodes on {_RMWS[1]}:
{", ".join(rows)}. The two RMWs of ROS 2 encode the identity of a request
differently, so services do not cross between them in ROS 2 either, and actions and parameters consist of services.
Topics, tf and QoS cross. What to do, one of:

- Source ROS 2 and run `graphrun` with `{HINT}`: it is then a node on the RMW that is sourced.
- Run the ROS 2 nodes with `RMW_IMPLEMENTATION={_RMWS[0]}`.

`graphrun` prints this when it sees such a peer. `graphrun ctl` controls a simulation without ROS 2 in any case."""


def _figures(cells: dict[tuple[str, str, str], Result]) -> Iterator[str]:
    yield """
## Figures

`->` is from this project to ROS 2, `<-` from ROS 2: messages received of those sent, the rate at which they were sent, the median
time from one program to the other, and the time until both ends found each other. All nodes are on one machine.
What the rows do not count:

- Best effort messages may be lost; the numbers say how many were.
- From a Fast DDS writer to embedded DDS, the first reliable message of 1 or 4 MB was lost (59 of 60, 19 of 20). In these two
  rows, each writer of ROS 2 sends one message before those that are counted.
- A client that calls at the moment at which it finds a server may get no answer to its first call. In `action server` and
  `parameters`, where clients wait for a server that starts, they call again after 5 s, up to 4 times; the row says if they did.
- `QoS events` are incompatible profiles and missed deadlines. Liveliness and matched events are left out: nodes on
  rmw_fastrtps_cpp did not get all of them within 20 s."""
    for row in ROWS:
        yield f"\n### {row}\n\n| transport | RMW of the peer | |\n|---|---|---|"
        for kind, rmw in COLUMNS:
            result = cells[row, kind, rmw]
            yield f"| {_NAMES[kind]} | {rmw} | {'' if result.works else f'{_NO}: '}{_plain(result.text)} |"


def _plain(text: str) -> str:
    """Return a text for a cell of a table."""
    return text.replace("|", "\\|").replace("\n", " ")


def _versions() -> Iterator[str]:
    found = packages()
    yield "\n## Versions\n\n| | |\n|---|---|"
    for name in ("rclpy", *_RMWS):
        yield f"| {name} | {found[name]} |"
    for name, path in _LIBRARIES.items():
        yield f"| {name} | {_library(path)} |"
    yield f"| Cyclone DDS of embedded DDS (PyPI: cyclonedds) | {version('cyclonedds')} |"
    yield f"| message definitions (PyPI: rosbags) | {version('rosbags')} |"


def _library(path: str) -> str:
    """Return the version in a CMake file of an installed library."""
    for prefix in filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)):
        for file in sorted(Path(prefix).parent.glob(f"*/{path}")):
            if match := re.search(r'set\(PACKAGE_VERSION "([\d.]+)"', file.read_text("utf-8")):
                return match[1]
    return "unknown"


def _distros() -> Iterator[str]:
    titles = " | ".join(distro.title() for distro in DISTROS)
    differing = distros.fields()
    yield f"""
{DISTROS_TITLE}

`--distro {"|".join(DISTROS)}` chooses the distribution whose message definitions are used; the default
is the sourced one, else Jazzy. Recordings keep it. All types have the same bytes and the same type hash in each distribution
that has them, except:

| fields | {titles} |
|---|{"---|" * len(DISTROS)}"""
    for name, each in differing.items():
        yield f"| {name} | " + " | ".join(", ".join(f"`{line}`" for line in lines) for lines in each) + " |"
    yield f"""
So do the types that contain them: {", ".join(sorted(distros.containing(set(differing))))}. Only in some distributions:

| type | {titles} |
|---|{"---|" * len(DISTROS)}"""
    for name, known in distros.missing():
        yield f"| {name} | " + " | ".join(_YES if has else "" for has in known) + " |"
    yield """
Shipped beside the definitions of the distributions: simulation_interfaces 1.5.1, which Jazzy and Kilted have (version 2 has
other fields in Spawnable, LoadWorld, SetEntityState and SpawnEntity, and is not spoken); control_msgs 5.8.0 for Jazzy, 6.3.0
and later for the others; vision_msgs 4.1.1 and ackermann_msgs 2.0.2 for all three."""
