"""Stubs of the USD stage and its prims.

The stubs record edits of graphs and nodes, and the namespaces of prims. Setting a property of another prim only adds a note to
the findings. Setting a `ui:` property adds none.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from graphengine.isaac.omniverse.graph_recorder import GraphRecorder, Place
from graphengine.isaac.omniverse.og_names import SIDES, OmniGraphError, absolute, stage_of
from graphengine.isaac.omniverse.plain_data import plain_data
from graphengine.isaac.omniverse.stubs import StubObject, member
from graphengine.isaac.omniverse.usd_values import SdfPath
from graphengine.isaac.recorded_graph import GRAPH, NAMESPACE, NODE, POSITION


class Property:
    """Stub of `Usd.Attribute` and `Usd.Relationship`."""

    def __init__(self, prim: UsdPrim, name: str) -> None:
        self.prim, self.name = prim, name

    def Set(self, value: Any, *_: Any) -> bool:
        """Set the value of an attribute, or the targets of a relationship; return True."""
        self.prim.set_property(self.name, value)
        return True

    SetTargets = Set

    def AddTarget(self, path: Any, *_: Any) -> bool:
        """Add a prim to the targets of a relationship; return True."""
        known = self.Get()
        return self.Set([*known, path] if isinstance(known, list) else [path])

    def ClearTargets(self, *_: Any) -> bool:
        """Remove all targets of a relationship; return True."""
        return self.Set([])

    def Get(self, *_: Any) -> Any:
        """Return the value that the script set; None if the script has not set it."""
        if self.name == NAMESPACE:
            return self.prim.recorder.namespaces.get(self.prim.path)
        place = self.prim.place(self.name)
        return self.prim.recorder.value(place) if place else None

    def GetTargets(self) -> list[Any]:
        """Return the paths of the prims that the relationship targets."""
        value = self.Get()
        return [SdfPath(path) for path in (value if isinstance(value, list) else [])]

    def AddConnection(self, source: Any, *_: Any) -> bool:
        """Add a wire from the attribute at the path `source` to this attribute of a node; return True."""
        recorder, place = self.prim.recorder, self.prim.place(self.name)
        if place is not None:
            recorder.connect(recorder.attribute(None, str(source)), place)
        return True

    def IsValid(self) -> bool:
        """Return whether the prim exists; the property itself is not checked."""
        return self.prim.IsValid()

    __bool__ = IsValid

    def __getattr__(self, name: str) -> Any:
        return member("UsdAttribute", name, self.prim.recorder)


class UsdPrim:
    """Stub of `Usd.Prim`: a recorded graph or node, or any other prim, of which only the path is known.

    Args:
        path: path of the prim.
        recorder: recorder of the graphs and nodes.
    """

    def __init__(self, path: Any, recorder: GraphRecorder) -> None:
        self.path = SdfPath(recorder.meant(str(path)))
        self.recorder = recorder

    def IsValid(self) -> bool:
        """Return whether the prim exists."""
        return self.recorder.exists(str(self.path))

    __bool__ = IsValid

    def GetPath(self) -> SdfPath:
        """Return the path of the prim."""
        return self.path

    GetPrimPath = GetPath

    def GetPrim(self) -> UsdPrim:
        """Return the prim itself, like a USD schema object."""
        return self

    def GetName(self) -> str:
        """Return the last part of the path."""
        return self.path.name

    def GetParent(self) -> UsdPrim:
        """Return the parent prim."""
        return UsdPrim(self.path.GetParentPath(), self.recorder)

    def GetChild(self, name: str) -> UsdPrim:
        """Return a child prim."""
        return UsdPrim(self.path.AppendChild(name), self.recorder)

    def GetAttribute(self, name: str, *_: Any, **__: Any) -> Property:
        """Return the property with this name. Arguments of `CreateAttribute`, such as the type, are ignored."""
        return Property(self, name)

    GetRelationship = GetProperty = CreateAttribute = CreateRelationship = GetAttribute

    def place(self, name: str) -> Place | None:
        """Return a reference to the attribute `name` if this prim is a recorded node; otherwise None."""
        found = self.recorder.graph_of(self.path)
        if found is None or found[1] not in found[0].nodes:
            return None
        return Place(found[0], found[1], name)

    def set_property(self, name: str, value: Any) -> None:
        """Record the value of a property of a graph or node, or a namespace; note that other prims are left out."""
        place, found = self.place(name), self.recorder.graph_of(self.path)
        if name == NAMESPACE:
            self._set_namespace(value)
        elif place is not None and name == "node:type":
            self.recorder.node(place).type = str(value)
        elif place is not None and name.startswith((POSITION, *SIDES)):
            self.recorder.set_value(place, value)
        elif found is not None and not found[1] and name == "pipelineStage":
            found[0].pipeline_stage = stage_of(value)
        elif found is not None and not found[1] and name == "evaluator:type":
            found[0].evaluator = str(value)
        elif found is None and not name.startswith("ui:"):
            self.recorder.pass_over(f"setting {name} of {self.path}")

    def _set_namespace(self, value: Any) -> None:
        with self.recorder.leaving_out_unknown(f"the namespace of {self.path}", NAMESPACE):
            path, namespace = plain_data(self.path), plain_data(value)
            if isinstance(namespace, str):
                self.recorder.count()
                self.recorder.namespaces[path] = namespace

    def plain_data(self) -> str:
        """Return the path of the prim as a string."""
        return str(self.path)

    def __getattr__(self, name: str) -> Any:
        return member("UsdPrim", name, self.recorder)


class UsdStage:
    """Stub of a USD stage, which records only graphs and nodes."""

    def __init__(self, recorder: GraphRecorder) -> None:
        self.recorder = recorder

    def GetPrimAtPath(self, path: Any) -> UsdPrim:
        """Return the prim at a path."""
        return UsdPrim(path, self.recorder)

    def DefinePrim(self, path: Any, type: str = "") -> UsdPrim:
        """Record a prim and return it: a new graph, a new node (its type follows later), or the path of any other prim."""
        found = self.recorder.graph_of(str(path))
        if type == GRAPH and not found:
            self.recorder.create_graph(str(path))
        elif type == NODE and found:
            self.recorder.create_node(found[0], found[1], "", exist_ok=True)
        else:
            if not found:
                self.recorder.pass_over(f"stage.DefinePrim({str(path)!r})")
            self.recorder.prims.add(str(path))
        return UsdPrim(path, self.recorder)

    OverridePrim = DefinePrim

    def GetPropertyAtPath(self, path: Any) -> Property:
        """Return the property at a path such as `/World/Graph/Node.inputs:x`."""
        prim, _, name = str(path).partition(".")
        return Property(UsdPrim(prim, self.recorder), name)

    GetAttributeAtPath = GetRelationshipAtPath = GetPropertyAtPath

    def RemovePrim(self, path: Any) -> bool:
        """Remove the graph or node at a path; return False if the path is not valid."""
        self.recorder.prims.discard(str(path))
        try:
            self.recorder.remove(absolute(str(path)))
        except OmniGraphError:
            return False
        return True

    def GetDefaultPrim(self) -> UsdPrim:
        """Return the prim `/World`, the default prim of a new stage in Isaac Sim."""
        self.recorder.prims.add("/World")
        return UsdPrim("/World", self.recorder)

    def Traverse(self) -> Iterator[UsdPrim]:
        """Yield the prims of all recorded graphs and nodes; note that the other prims of the stage are unknown."""
        self.recorder.search("the stage")
        for graph in list(self.recorder.graphs.values()):
            for path in (graph.path, *(f"{graph.path}/{name}" for name in graph.nodes)):
                yield UsdPrim(path, self.recorder)

    def __getattr__(self, name: str) -> Any:
        return member("stage", name, self.recorder)


class Schema(StubObject):
    """Stub of a schema class of `pxr.UsdGeom`, such as `Xform`; calling it with a prim returns the prim."""

    def __init__(self, name: str, stage: UsdStage) -> None:
        self.__dict__.update(_recorder=stage.recorder, _stage=stage)

    def __call__(self, *arguments: Any, **named: Any) -> Any:  # noqa: D102
        first = arguments[0] if arguments else None
        return first if isinstance(first, UsdPrim) else super().__call__(*arguments, **named)

    def Define(self, _: Any, path: Any) -> UsdPrim:
        """Record the path of a prim and return the prim; the prim type is not recorded."""
        return self._stage.DefinePrim(path)  # type: ignore[no-any-return]

    def Get(self, _: Any, path: Any) -> UsdPrim:
        """Return the prim at a path."""
        return self._stage.GetPrimAtPath(path)  # type: ignore[no-any-return]
