"""A small graph for each node type, which `check` accepts, and the drawing of the node."""

from __future__ import annotations

import json
import re
from pathlib import Path

import yaml

from graphengine.cli.node_description import summary
from graphengine.cli.node_reference import last_part
from graphengine.compiler.graph import Graph
from graphengine.compiler.registry import default_registry
from graphengine.drawing import svg
from graphengine.drawing.view_model import GraphView, NodeView, PortView
from graphengine.node.node_class import Node
from graphengine.node.port import Port
from graphengine.scene import build
from graphengine.scene.loaded_scene import Options
from tests.nodes.data.test_in_graphs import literal
from tests.nodes.test_ports import NEEDED

_ODOMETRY = "{type: ComputeOdometry, inputs: {chassisPrim: /dd100}}"
_REQUEST = (
    "{type: ROS2ServiceServerRequest, inputs: {messagePackage: std_srvs, messageName: SetBool, serviceName: set}}"
)
_GOAL = "{type: ROS2ActionServerGoal, inputs: {messagePackage: example_interfaces, messageName: Fibonacci, actionName: count}}"
_PRODUCT = "{type: CreateRenderProduct, inputs: {cameraPrim: /dd100/Geometry/base_link/Front, width: 64, height: 48}}"
_PARTNERS: dict[str, tuple[str, str, dict[str, str]]] = {
    "CheckGoal2D": ("Odometry", _ODOMETRY, {"currentPosition": "position", "currentOrientation": "orientation"}),
    "IsaacSetCameraOnRenderProduct": (
        "Product",
        _PRODUCT,
        {"execIn": "execOut", "renderProductPath": "renderProductPath"},
    ),
    "OgnROS2ServiceServerResponse": ("Request", _REQUEST, {"onReceived": "onReceived", "serverHandle": "serverHandle"}),
    "ROS2ActionServerFeedback": ("Goal", _GOAL, {"execIn": "onGoal", "serverHandle": "serverHandle"}),
}
"""For types that need another node: its name, the node, and the inputs that are wired from it."""
_PARTNERS |= dict.fromkeys(("QuinticPathPlanner", "StanleyControlPID"), _PARTNERS["CheckGoal2D"])
_PARTNERS["ROS2ActionServerResult"] = _PARTNERS["ROS2ActionServerFeedback"]
_SCRIPT = {"script": "def compute(db):\n    db.log_info('hello')"}
_EDGE = 6.0
"""Space around the box of a drawn node, px."""
OPTIONS = Options(environment={"ROBOT": "dd100"}, scripts=True)
"""As with `--env ROBOT --allow-scripts`, which two of the types need."""


def example_of(cls: type[Node]) -> str:
    """Return a graph with one node of a type and its required inputs: a tick executes it, or a printer reads its output."""
    name = last_part(cls)
    given = {"ScriptNode": _SCRIPT}.get(name, NEEDED.get(cls.__name__, {}))
    inputs = {cls.fields[field].name: literal(cls, field, value) for field, value in given.items()}
    inputs = json.loads(json.dumps(inputs).replace('"/robot', '"/dd100'))
    partner, of_partner, fed = _PARTNERS.get(name, ("", "", {}))
    nodes, wires = {"Tick": "OnPlaybackTick"}, [f"{partner}.{source} -> {name}.{port}" for port, source in fed.items()]
    begin, end = (_first_pin(cls, side) for side in ("inputs", "outputs"))
    if partner:
        nodes[partner] = of_partner
        wires.insert(0, f"Tick.tick -> {partner}.execIn")
    if begin is not None:
        wires += [f"Tick.tick -> {name}.{begin.name}"] if begin.name not in fed else []
    elif end is not None:
        nodes = {"Print": "PrintText"}
        wires.append(f"{name}.{end.name} -> Print.execIn")
    else:  # others read the input of a constant, which has no output
        source = next((port.name for port in cls.fields.values() if port.side == "outputs"), "inputs:value")
        nodes |= {"Text": "ToString", "Print": "PrintText"}
        wires += [f"{name}.{source} -> Text.value", "Text.converted -> Print.text", "Tick.tick -> Print.execIn"]
    stamp = cls.fields.get("time_stamp")
    if stamp is not None and stamp.side == "inputs":  # without a time, all messages are stamped 0
        nodes["Time"] = "IsaacReadSimulationTime"
        wires.append(f"Time.simulationTime -> {name}.{stamp.name}")
    lines = ["format: 1", "graph: example"]
    lines += ["runs: physics_step"] if name == "OnPhysicsStep" else []
    lines += ["variables: {speed: {type: double, default: 1.0}}"] if "variableName" in inputs else []
    lines += ["nodes:", *(f"  {other}: {kind}" for other, kind in nodes.items())]
    values = {port: value for port, value in inputs.items() if port not in fed}
    lines += [f"  {name}:", f"    type: {cls.type_name}", "    inputs:"] if values else [f"  {name}: {cls.type_name}"]
    lines += [f"      {port}: {json.dumps(value)}" for port, value in values.items()]
    return "\n".join([*lines, "connections:", *(f"  - {wire}" for wire in wires), ""])


def _first_pin(cls: type[Node], side: str) -> Port | None:
    return next((port for port in cls.fields.values() if port.is_exec and port.side == side), None)


def checked(text: str, folder: Path) -> Graph:
    """Return the graph of an example.

    Raises:
        ValueError: the check finds something in it.
    """
    path = folder / "example.yaml"
    path.write_text(text, encoding="utf-8")
    scene = build.load(path, OPTIONS)
    if scene.findings.errors or scene.findings.warnings or not scene.graphs:
        raise ValueError(f"{text}\n{[finding.message for finding in scene.findings.sorted()]}")
    return scene.graphs[0]


def drawing_of(cls: type[Node]) -> str:
    """Return the drawing of a node with all of its ports, as SVG."""
    node = NodeView(last_part(cls), cls.kind(), cls.kind(), None, summary(cls))
    ports = (port for port in cls.fields.values() if port.side != "state")
    for port in sorted(ports, key=lambda port: not port.is_exec):
        side = "left" if port.side == "inputs" else "right"
        node.ports[side, port.name] = PortView(port.name, port.is_exec, about=port.doc)
    return _cropped(svg.draw([GraphView(cls.type_name, "", [node], [], {}, [])]))


def _cropped(drawing: str) -> str:
    """Return a drawing of one box without what is around it: the heading of the graph, and the room for a legend."""
    places = re.findall(r"translate\(([\d.]+) ([\d.]+)\)", drawing)
    left, top = (sum(float(place[axis]) for place in places[:2]) - _EDGE for axis in (0, 1))
    (box, *_) = re.findall(r'class="box" width="([\d.]+)" height="([\d.]+)"', drawing)
    wide, high = (float(side) + 2 * _EDGE for side in box)
    size = f'width="{wide:g}" height="{high:g}" viewBox="{left:g} {top:g} {wide:g} {high:g}"'
    sized = re.sub(r'width="\S+" height="\S+" viewBox="[^"]+"', size, drawing, count=1)
    return re.sub(r'<text class="(title|caption)".*\n', "", sized)


def used_in(root: Path) -> dict[str, list[str]]:
    """Return the names of the shipped graphs that use each node type, by registered name."""
    used: dict[str, set[str]] = {}
    for path in sorted((root / "graphs").rglob("*.yaml")):
        name = str(path.relative_to(root / "graphs").with_suffix(""))
        for node in yaml.safe_load(path.read_text(encoding="utf-8"))["nodes"].values():
            found = default_registry().find(node if isinstance(node, str) else node.get("type", ""))
            if found is not None:
                used.setdefault(found.cls.type_name, set()).add(name)
    return {name: sorted(graphs) for name, graphs in used.items()}
