"""The pages of node types, a page for each family of the library."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from graphengine.cli.node_description import summary
from graphengine.cli.node_reference import code, description, last_part, prose, table
from graphengine.compiler.registry import default_registry
from graphengine.node.node_class import Node
from tests.cli.harness import ROOT
from tests.docs.generate.examples import drawing_of, example_of, used_in


class Family(NamedTuple):
    """A page of node types: its title, one sentence, and the modules of the library whose types it has."""

    title: str
    about: str
    modules: str


FAMILIES = {
    "action": Family(
        "Events and execution", "Events start a graph; gates, branches and loops direct its execution.", "action"
    ),
    "time": Family(
        "Time and simulation",
        "Simulation time, system time, frames, and gates that follow them.",
        "core.time core.flow core.units core.echo data.time",
    ),
    "robots": Family(
        "Robots",
        "Joints, wheels, grippers, conveyors, odometry and poses of the robots of a scene.",
        "core.articulation core.actuators core.odometry core.transforms wheeled_robots grippers conveyor",
    ),
    "sensors": Family(
        "Sensors",
        "Lidars, IMUs, contact sensors, ray casts and point clouds.",
        "physics_sensors ray_sensors lidar point_buffers",
    ),
    "cameras": Family(
        "Cameras",
        "Cameras, their render products and images.",
        "core.image_buffers core.render_product core.viewport",
    ),
    "ros2": Family("ROS 2", "Publishers, subscribers, services, actions and transforms.", "ros2"),
    "stage": Family(
        "Prims, variables, files and scripts",
        "Attributes of prims, variables of graphs, files, environment variables and scripts.",
        "prims variables script core.outside",
    ),
    "math": Family(
        "Mathematics and logic",
        "Arithmetic, functions, comparison, logic, selection, random numbers.",
        "data.arithmetic data.functions data.trigonometry data.interpolation data.random data.comparison data.logic"
        " data.selection",
    ),
    "vectors": Family(
        "Vectors, matrices and rotations",
        "Vectors, matrices, quaternions and angles.",
        "data.vectors data.matrices data.rotations",
    ),
    "arrays": Family("Arrays", "Arrays of values and their elements.", "data.arrays data.construction data.nearest"),
    "text": Family(
        "Text, paths and conversion",
        "Strings, tokens, paths of prims, and conversion between types.",
        "data.strings data.substrings data.paths data.targets data.conversion",
    ),
    "constants": Family("Constants", "A constant of each type.", "data.constants"),
}
"""Family of each page below docs/reference/nodes, in the order of the overview."""

_INTRODUCTION = """# Node types

graphengine has {total} node types. A graph file names a type by its registered name or by the last part of this name. `Isaac`,
`ROS2` or `Ogn` at the beginning of the last part can be left out: `PublishClock` is `isaacsim.ros2.bridge.ROS2PublishClock`.
`graphrun nodes NAME` prints the same descriptions, and `graphrun nodes --search wheel` finds types. The node in Isaac Sim does
not have the ports that are marked as "extension". Each description ends with a small graph that `graphrun check` accepts;
`/dd100` in this graph stands for the prim of a robot."""

_KINDS = (
    ("data", "has no execution ports; it is computed when a node that is executed reads its outputs"),
    ("action", "is executed when an execution wire reaches it, and then fires its outputs"),
    ("event", "starts the execution: it is computed at the start of each pass"),
    ("pusher", "fires its outputs one after the other within one execution, as loops do"),
    ("latent", "goes on over several ticks and fires when it is done"),
)


def types_by_family() -> dict[str, list[type[Node]]]:
    """Return the node types of each page, sorted by name.

    Raises:
        ValueError: a type has no family, or several.
    """
    found: dict[str, list[type[Node]]] = {name: [] for name in FAMILIES}
    for name, cls in sorted(default_registry().types.items(), key=lambda item: last_part(item[1]).lower()):
        if name == cls.type_name:
            module = cls.__module__.removeprefix("graphengine.nodes.") + "."
            families = [
                key
                for key, family in FAMILIES.items()
                if any(module.startswith(f"{part}.") for part in family.modules.split())
            ]
            if len(families) != 1:
                raise SystemExit(
                    f"{cls.type_name}: name its module nodes/{module.replace('.', '/')[:-1]}.py in one of FAMILIES"
                )
            found[families[0]].append(cls)
    return found


def pages() -> Iterator[tuple[str, str]]:
    """Yield path and text of each page and each drawing."""
    families, used = types_by_family(), used_in(ROOT)
    yield "nodes/index.md", _overview(families)
    for family, types in families.items():
        yield f"nodes/{family}.md", "\n".join([*_page(FAMILIES[family], types, used), ""])
        for cls in types:
            yield f"nodes/pictures/{cls.type_name}.svg", drawing_of(cls)


def _overview(families: dict[str, list[type[Node]]]) -> str:
    rows = [(f"[{one.title}]({name}.md)", str(len(families[name])), one.about) for name, one in FAMILIES.items()]
    lines = [_INTRODUCTION.format(total=sum(map(len, families.values()))), "", *table(("family", "types", ""), rows)]
    lines += ["", "## Kinds", "", "Each node type has a kind, which determines when nodes of this type run:", ""]
    lines += [*table(("kind", "a node of this kind"), _KINDS), "", "## All types", ""]
    every = sorted((last_part(cls), family, cls) for family, types in families.items() for cls in types)
    entries = [
        (_link(name, f"{family}.md"), code(cls.type_name.rpartition(".")[0]), prose(summary(cls)))
        for name, family, cls in every
    ]
    return "\n".join([*lines, *table(("type", "registered in", "what it does"), entries), ""])


def _link(name: str, page: str = "") -> str:
    return f"[{code(name)}]({page}#{name.lower()})"


def _page(family: Family, types: list[type[Node]], used: dict[str, list[str]]) -> Iterable[str]:
    yield from (f"# {family.title}", "", f"{family.about} Units are SI unless a port says otherwise.", "")
    rows = [(_link(last_part(cls)), cls.kind(), prose(summary(cls))) for cls in types]
    yield from table(("type", "kind", "what it does"), rows)
    for cls in types:
        yield from ("", f"## {last_part(cls)}", "", f"![{last_part(cls)}](pictures/{cls.type_name}.svg)", "")
        yield from description(cls)
        yield from ("", "```yaml", *example_of(cls).splitlines(), "```")
        if graphs := used.get(cls.type_name):
            shown = ", ".join(code(f"graphrun show {graph}") for graph in graphs[:4])
            yield from ("", f"These commands show graphs that use the node type: {shown}.")
