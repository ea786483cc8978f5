"""Paths of prims (`omni.graph.nodes`)."""

from __future__ import annotations

from typing import Any

from graphengine.node import BadValueError, Bound, Context, In, Node, Out, Target, Token, Tokens


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


def parent_of(path: str) -> str:
    """The path without its last name, which may be that of a property; what is no path stays."""
    if "." in path.rpartition("/")[2]:
        return path.rpartition(".")[0]
    above, slash, _ = path.rpartition("/")
    return above or slash or path


def below(path: str, suffix: str) -> str:
    """A path with names behind it; what is no path stays."""
    between = "" if suffix.startswith(".") else "/"
    return f"{path.rstrip('/')}{between}{suffix}" if path and suffix else path


class AppendPath(Node, type="omni.graph.nodes.AppendPath"):
    """A path with names behind it, such as /World/box of /World and box."""

    path_in: Any = In(type="token|token[]", name="path", couple="path", required=True, doc="a prim's, or several")
    suffix: Token = In(default="", doc="names of prims below it, and of a property, such as box/lid or box.mass")
    path_out: Any = Out(type="token|token[]", name="path", couple="path", doc="of the type of the input")

    def compute(self) -> None:
        """Append.

        Raises:
            BadValueError: the suffix begins with a slash.
        """
        if self.suffix.startswith("/"):
            raise BadValueError("suffix", self.suffix, "names to append, without a / in front")
        path, suffix = self.path_in, self.suffix
        self.path_out = below(path, suffix) if isinstance(path, str) else tuple(below(one, suffix) for one in path)


class GetParentPath(Node, type="omni.graph.nodes.GetParentPath"):
    """The path of what is above a prim, such as /World of /World/box."""

    path: Any = In(type="token|token[]", couple="path", required=True, doc="a prim's or a property's, or several")
    parent_path: Any = Out(type="token|token[]", couple="path", doc="of the type of the input")

    def compute(self) -> None:
        """Cut the last name off."""
        path = self.path
        self.parent_path = parent_of(path) if isinstance(path, str) else tuple(map(parent_of, path))


class GraphPathNode(Node):
    """A node that tells where its graph is put."""

    path: str = Bound()

    def setup(self, context: Context) -> None:
        """Ask for the path of that prim."""
        self.path = context.graph_path


class GraphTarget(GraphPathNode, type="omni.graph.nodes.GraphTarget"):
    """Path of the prim that the node's graph is put at."""

    target_path: Token = In(default="", doc="means nothing, as in the reference")
    prim_path: Token = Out()

    def compute(self) -> None:
        """Tell it."""
        self.prim_path = self.path


class GetGraphTargetPrim(GraphPathNode, type="omni.graph.nodes.GetGraphTargetPrim"):
    """The prim that the node's graph is put at."""

    prim: Target = Out(doc="that prim")

    def compute(self) -> None:
        """Tell it."""
        self.prim = (self.path,)
