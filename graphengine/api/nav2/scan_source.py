"""The LaserScan topics of a robot, with the properties of their lidars."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from graphengine.compiler.graph import Graph
from graphengine.devices.stage import Prim
from graphengine.messages.endpoints import EndpointClaim
from graphengine.scene.loaded_scene import LoadedScene

SCAN = "sensor_msgs/msg/LaserScan"


@dataclass(frozen=True, slots=True)
class ScanSource:
    """A LaserScan topic.

    Attributes:
        topic: full name of the topic.
        frame: frame of its messages.
        ranges: smallest and largest measured distance, m.
        view: field of view, rad.
        rate: scans per second.
        height: height of the scan plane, m, in the world; `above` makes it relative to a floor.
    """

    topic: str
    frame: str
    ranges: tuple[float, float]
    view: float
    rate: float
    height: float

    def above(self, floor: float) -> ScanSource:
        """Return a copy whose height is relative to a floor; `floor` is the height of the floor in the world, m."""
        return replace(self, height=self.height - floor)


def scan_sources(scene: LoadedScene, claims: Sequence[EndpointClaim]) -> list[ScanSource]:
    """Return the scans that the graphs publish, the widest field of view first."""
    assert scene.world is not None
    found: dict[str, ScanSource] = {}
    for claim in claims:
        if claim.direction != "publish" or claim.message_type != SCAN or claim.topic in found:
            continue
        prim = _lidar(scene, claim)
        if prim is not None:
            (first, last, _), ranges = prim.facts["angles"], prim.facts["ranges"]
            (_, _, height), _ = scene.world.simulation.frame(prim).pose()
            rate = claim.rate or prim.facts.get("rate", 10.0)
            found[claim.topic] = ScanSource(claim.topic, claim.frame_id, ranges, last - first, rate, height)
    return sorted(found.values(), key=lambda scan: (-scan.view, scan.topic))


def _lidar(scene: LoadedScene, claim: EndpointClaim) -> Prim | None:
    """Return the first lidar that is found upstream of the publisher; None if there is none."""
    for graph in scene.planned:
        if claim.node.startswith(f"{graph.prim_path}/"):
            node = claim.node.removeprefix(f"{graph.prim_path}/")
            for path in _upstream_paths(graph, node):
                if path in scene.stage:
                    prims = (prim for prim in scene.stage.find(path).descendants() if "angles" in prim.facts)
                    if (prim := next(prims, None)) is not None:
                        return prim
    return None


def _upstream_paths(graph: Graph, node: str) -> Iterator[str]:
    """Yield the prim paths in the inputs of a node and of the nodes upstream of it, nearest first."""
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
