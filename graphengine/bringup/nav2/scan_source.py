"""Finds the LaserScan topics of a robot and the properties of their lidars."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from graphengine.api.scene import Scene, loaded_of, world_of
from graphengine.bringup.calibration.robot_interface import claims_of
from graphengine.compiler.graph import Graph
from graphengine.devices.stage import Prim
from graphengine.messages.endpoints import EndpointClaim

SCAN = "sensor_msgs/msg/LaserScan"


@dataclass(frozen=True, slots=True)
class ScanSource:
    """A LaserScan topic.

    Attributes:
        topic: full name of the topic.
        frame: TF frame of the scans.
        ranges: smallest and largest range of the lidar, m.
        view: horizontal field of view, rad.
        rate: scans per second.
        height: height of the lidar in the world, m; in copies by `above`, relative to a floor.
    """

    topic: str
    frame: str
    ranges: tuple[float, float]
    view: float
    rate: float
    height: float

    def above(self, floor: float) -> ScanSource:
        """Return a copy whose `height` is measured from a floor; `floor` is the height of this floor in the world, m."""
        return replace(self, height=self.height - floor)


def scan_sources(scene: Scene, claims: Sequence[EndpointClaim]) -> list[ScanSource]:
    """Return the LaserScan topics that the graphs publish, sorted from the widest to the narrowest field of view."""
    found: dict[str, ScanSource] = {}
    for claim in claims_of(claims, "publish", SCAN):
        if claim.topic not in found and (prim := _lidar(scene, claim)) is not None:
            (first, last, _), ranges = prim.facts["angles"], prim.facts["ranges"]
            (_, _, height), _ = world_of(scene).simulation.frame(prim).pose()
            rate = claim.rate or prim.facts.get("rate", 10.0)
            found[claim.topic] = ScanSource(claim.topic, claim.frame_id, ranges, last - first, rate, height)
    return sorted(found.values(), key=lambda scan: (-scan.view, scan.topic))


def _lidar(scene: Scene, claim: EndpointClaim) -> Prim | None:
    """Return the lidar whose prim path is nearest upstream of the publishing node; None without a lidar."""
    stage = world_of(scene).stage
    for graph in loaded_of(scene).planned:
        if claim.node.startswith(f"{graph.prim_path}/"):
            paths = _upstream_paths(graph, claim.node.removeprefix(f"{graph.prim_path}/"))
            prims = (prim for path in paths if path in stage for prim in stage.find(path).descendants())
            if (lidar := next((prim for prim in prims if "angles" in prim.facts), None)) is not None:
                return lidar
    return None


def _upstream_paths(graph: Graph, node: str) -> Iterator[str]:
    """Yield the prim paths among the input values of a node and of its upstream nodes, the nearest node first."""
    pending = [one.index for one in graph.instances if one.id == node]
    seen = set(pending)
    for index in pending:
        instance = graph.instances[index]
        for value in instance.literals.values():
            texts = [value] if isinstance(value, str) else value if isinstance(value, list | tuple) else []
            yield from (text for text in texts if isinstance(text, str) and text.startswith("/"))
        for wire in (*graph.data_wires, *graph.exec_wires):
            if wire.target == index and wire.source not in seen:
                seen.add(wire.source)
                pending.append(wire.source)
