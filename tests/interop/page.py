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

Each cell of the table is the result of a test between graphengine and an rclpy node in another process. A row names the feature
under test and, for services and actions, the role of graphengine: in `service server`, graphengine offers a service and the ROS 2
node calls this service. A column names the transport of graphengine and the RMW of the ROS 2 node. Embedded DDS needs no ROS 2
installation; `--transport rclpy` uses the sourced ROS 2.

With a sourced ROS 2, `python -m tests.interop.matrix` runs the tests and writes this page. `tests/interop/test_matrix.py` fails
if a result differs from the following table: if the test of a cell with `yes` fails, or if the test of a cell with `no` passes.
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

Between embedded DDS, which is Cyclone DDS, and nodes on {_RMWS[1]}, these features fail:
{", ".join(rows)}.
rmw_cyclonedds_cpp and rmw_fastrtps_cpp encode the identity of a request differently, so services
between two ROS 2 nodes on these two RMWs fail, too.
Actions and parameters use services, so they fail for the same reason. Topics, tf and QoS events work. There are two remedies:

- Source ROS 2, or install [rclpy from PyPI](ros_from_pypi.md), and run `graphrun` with `{HINT}`. The run is then a node
  on the RMW of this rclpy.
- If ros-jazzy-rmw-cyclonedds-cpp is installed, run the nodes of a sourced ROS 2 with `RMW_IMPLEMENTATION={_RMWS[0]}`. If
  this package is missing, or if rclpy is from PyPI, the variable makes each rclpy program exit with code 102.

`graphrun` prints these remedies when it discovers a peer on another RMW. `graphrun ctl` needs no ROS 2 and works with any
transport."""


def _figures(cells: dict[tuple[str, str, str], Result]) -> Iterator[str]:
    yield """
## Measurements

`->` means from graphengine to ROS 2, and `<-` means from ROS 2 to graphengine. An entry such as
`100/100 at 50 Hz, 0.7 ms, found in 0.23 s` gives the number of received messages and the number of sent messages, the rate of
sending, the median latency between the two processes, and the discovery time. All processes ran on one machine.

An entry of `late joiner` gives the time until the first message arrives. The fraction after `then`, such as `479/479`, gives the
number of received messages and the number of sent messages, both counted from this first message. In `kill -9 of the peer`,
graphengine continues to write after the peer is killed. The entry gives the time until graphengine notices that the peer is gone,
and the duration of the longest write until then.

The tests have these limits:

- A test does not fail if best-effort messages are lost; the entries show how many messages arrived.
- Embedded DDS lost the first reliable message of 1 MB (59 of 60 arrived) and of 4 MB (19 of 20 arrived) from a Fast DDS writer.
  Therefore, in the tests with these sizes, each ROS 2 writer first sends one message that is not counted.
- If a client calls a server as soon as it discovers the server, the first call may get no response. In `action server` and
  `parameters`, the client is already waiting when the server starts. In these tests, the client therefore repeats an
  unanswered call after 5 s, at most 4 times. If calls were repeated, the entry gives their number.
- `QoS events` tests incompatible QoS profiles and missed deadlines. Liveliness events and matched events are not tested, because
  nodes on rmw_fastrtps_cpp did not get all of these events within 20 s."""
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

`--distro {"|".join(DISTROS)}` selects the distribution whose message definitions graphengine uses. The
default is the sourced distribution, or Jazzy if none is sourced. Recordings store the selection. Except for the types in the
following table, a type has the same encoding and the same type hash in all distributions that have it. The table lists the fields
that differ:

| type | {titles} |
|---|{"---|" * len(DISTROS)}"""
    for name, each in differing.items():
        yield f"| {name} | " + " | ".join(", ".join(f"`{line}`" for line in lines) for lines in each) + " |"
    yield f"""
The following types contain a type of the table, so their type hashes differ, too:
{", ".join(sorted(distros.containing(set(differing))))}.

The following types exist only in the distributions that are marked with `yes`:

| type | {titles} |
|---|{"---|" * len(DISTROS)}"""
    for name, known in distros.missing():
        yield f"| {name} | " + " | ".join(_YES if has else "" for has in known) + " |"
    yield """
In addition to the message definitions of the distributions, graphengine contains those of the following packages:

- simulation_interfaces 1.5.1, the version in Jazzy and Kilted. graphengine does not support version 2, which has other fields in
  Spawnable, LoadWorld, SetEntityState and SpawnEntity.
- control_msgs 5.8.0 for Jazzy, and 6.3.0 for Kilted and Lyrical.
- vision_msgs 4.1.1 and ackermann_msgs 2.0.2 for all three distributions."""
