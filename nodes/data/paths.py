"""Paths of prims (`omni.graph.nodes`)."""

from __future__ import annotations

from typing import Any

from graphengine.context import Context
from graphengine.node import In, Node, Out, State
from graphengine.types import Target, Token, Tokens


class GetPrimPath(Node, type="omni.graph.nodes.GetPrimPath"):
    """Path of a prim, as text."""

    prim: Target = In(default=(), doc="of several the first counts; of none the path is empty")
    path: Any = Out(type="path", doc="the prim's path")
    prim_path: Token = Out()

    def compute(self) -> None:
        """Take the first."""
        self.path = self.prim_path = self.prim[0] if self.prim else ""


class GetPrimPaths(Node, type="omni.graph.nodes.GetPrimPaths"):
    """Paths of prims, as texts."""

    prims: Target = In(default=(), doc="any prims")
    prim_paths: Tokens = Out()

    def compute(self) -> None:
        """Take them all."""
        self.prim_paths = self.prims


class GraphTarget(Node, type="omni.graph.nodes.GraphTarget"):
    """Path of the prim that the node's graph is put at."""

    target_path: Token = In(default="", doc="means nothing, as in the reference")
    prim_path: Token = Out()

    path: str = State()

    def setup(self, context: Context) -> None:
        """Ask for it."""
        self.path = context.graph_path

    def compute(self) -> None:
        """Tell it."""
        self.prim_path = self.path


class GetGraphTargetPrim(Node, type="omni.graph.nodes.GetGraphTargetPrim"):
    """The prim that the node's graph is put at."""

    prim: Target = Out(doc="that prim")

    path: str = State()

    def setup(self, context: Context) -> None:
        """Ask for it."""
        self.path = context.graph_path

    def compute(self) -> None:
        """Tell it."""
        self.prim = (self.path,)
