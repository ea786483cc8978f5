"""The confined process in which USD reads one stage: it reads a request from stdin and writes the result to stdout.

USD's readers are native code that reads an untrusted file. Therefore the process is limited and confined, and a crash of the
reader ends only this process.
"""

from __future__ import annotations

from typing import Any

from pxr import Usd

from graphengine.descriptions.usd.confined_reading import ConfinedReading, prims
from graphengine.descriptions.usd.layers import variants_of
from graphengine.format.files import Files
from graphengine.isaac.recorded_graph import GRAPH, NAMESPACE, NODE, POSITION, VARIABLE
from graphengine.isaac.stage.stage_contents import COMPOUND, INSTANCES, StageAttribute, StageContents, StagePrim
from graphengine.isaac.stage.usd_conversion import plain_value, type_name

_GRAPH_SETTINGS = ("evaluator:type", "evaluationMode", "pipelineStage")
_NODE_SETTINGS = ("node:type", "node:typeVersion", POSITION, COMPOUND)
_EXTENDED = ("Union", "Any")
"""Prefixes of the custom data `attrType` of union and `any` ports, as in `Union-->double,float`."""


class StageReading(ConfinedReading[StageContents]):
    """Reader of the parts of one stage that concern graphs."""

    def __init__(self, files: Files, **choice: Any) -> None:
        super().__init__(files, **choice)
        self.contents = StageContents()

    def read(self, stage: Usd.Stage) -> None:
        """Read the prims that concern graphs, and the attributes to which their nodes are connected."""
        for prim in prims(stage):
            self._read(prim)  # prims below a missing asset too, such as one on NVIDIA's server
        self._read_sources(stage)

    def _read(self, prim: Usd.Prim) -> None:
        """Store the variant selections of a prim, and the prim itself if it concerns graphs."""
        variants_of(prim, self.contents.choices)
        kind = str(prim.GetTypeName())
        names = [name for name in (NAMESPACE, INSTANCES) if prim.HasProperty(name)]
        if not names and kind not in (GRAPH, NODE):
            return
        found = StagePrim(str(prim.GetPath()), kind)
        for item in prim.GetAuthoredProperties():
            name = str(item.GetName())
            if not _matters(kind, name):
                continue
            if isinstance(item, Usd.Relationship):
                found.targets[name] = [str(target) for target in item.GetTargets()]
            else:
                found.attributes[name] = self._attribute(item)
        self.contents.prims[found.path] = found

    def _attribute(self, attribute: Usd.Attribute) -> StageAttribute:
        meaning = attribute.GetCustomDataByKey("omni:graph")
        meaning = meaning if isinstance(meaning, dict) else {}
        found = StageAttribute(type_name(str(attribute.GetTypeName())))
        found.sources = [str(source) for source in attribute.GetConnections()]
        found.execution = bool(attribute.GetCustomDataByKey("isExecution"))
        if "resolvedType" in meaning or str(meaning.get("attrType", "")).startswith(_EXTENDED):
            found.type = str(meaning.get("resolvedType", ""))
            found.value = self._plain(attribute, meaning.get("attrValue"), found.type)
        elif attribute.HasAuthoredValue() and not found.execution:
            found.value = self._plain(attribute, attribute.Get(Usd.TimeCode.Default()), found.type)
            if found.value is None and attribute.GetNumTimeSamples():
                self.contents.left_out.append((str(attribute.GetPath()), "its value changes with time"))
        return found

    def _plain(self, attribute: Usd.Attribute, value: Any, type: str) -> Any:
        try:
            return plain_value(value, type)
        except ValueError as error:
            self.contents.left_out.append((str(attribute.GetPath()), str(error)))
            return None

    def _read_sources(self, stage: Usd.Stage) -> None:
        """Store the attributes outside of nodes to which nodes are connected."""
        found = self.contents.prims.values()
        for source in sorted({path for prim in found for item in prim.attributes.values() for path in item.sources}):
            owner = source.partition(".")[0]
            known = self.contents.prims.get(owner)
            if (known is None or known.type != NODE) and (attribute := stage.GetAttributeAtPath(source)):
                self.contents.plain[source] = self._attribute(attribute)


def _matters(kind: str, name: str) -> bool:
    """Return whether an import needs the property `name` of a prim of type `kind`: settings, ports, variables, namespaces."""
    if name in (NAMESPACE, INSTANCES) or name.startswith(VARIABLE):
        return True
    if kind == GRAPH:
        return name in _GRAPH_SETTINGS
    return kind == NODE and (name in _NODE_SETTINGS or name.startswith(("inputs:", "outputs:")))


if __name__ == "__main__":
    StageReading.serve()
