"""Prim paths (`omni.graph.nodes`)."""

from __future__ import annotations

from typing import Any

from graphengine.node import BadValueError, Bound, Context, In, Node, Out, Target, Token, Tokens


class GetPrimPath(Node, type="omni.graph.nodes.GetPrimPath"):
    """Path of a prim."""

    prim: Target = In(default=(), doc="prim whose path is output; only the first of several counts")
    path: Any = Out(type="path", doc="path of the prim; empty if there is none")
    prim_path: Token = Out(doc="path of the prim as a token; empty if there is none")

    def compute(self) -> None:
        """Output the path of the first prim."""
        self.path = self.prim_path = self.prim[0] if self.prim else ""


class GetPrimPaths(Node, type="omni.graph.nodes.GetPrimPaths"):
    """Paths of prims as tokens."""

    prims: Target = In(default=(), doc="prims whose paths are output")
    prim_paths: Tokens = Out()

    def compute(self) -> None:
        """Output all paths."""
        self.prim_paths = self.prims


def parent_of(path: str) -> str:
    """Return the path without its last name, which may be a property; a string without `/` and `.` stays the same."""
    if "." in path.rpartition("/")[2]:
        return path.rpartition(".")[0]
    above, slash, _ = path.rpartition("/")
    return above or slash or path


def below(path: str, suffix: str) -> str:
    """Return the path with the suffix path appended; an empty path stays empty."""
    between = "" if suffix.startswith(".") else "/"
    return f"{path.rstrip('/')}{between}{suffix}" if path and suffix else path


class AppendPath(Node, type="omni.graph.nodes.AppendPath"):
    """A path with names appended: `/World` and `box` give `/World/box`."""

    path_in: Any = In(
        type="token|token[]", name="path", couple="path", required=True, doc="prim path to extend, or array of paths"
    )
    suffix: Token = In(
        default="", doc="names of descendant prims, a property, or both, such as `box/lid` or `box.mass`"
    )
    path_out: Any = Out(type="token|token[]", name="path", couple="path", doc="extended path, of the input's type")

    def compute(self) -> None:
        """Append the suffix.

        Raises:
            BadValueError: the suffix begins with a slash.
        """
        if self.suffix.startswith("/"):
            raise BadValueError("suffix", self.suffix, "names to append, without a / in front")
        path, suffix = self.path_in, self.suffix
        self.path_out = below(path, suffix) if isinstance(path, str) else tuple(below(one, suffix) for one in path)


class GetParentPath(Node, type="omni.graph.nodes.GetParentPath"):
    """The path of the parent of a prim or property, such as `/World` for `/World/box`."""

    path: Any = In(
        type="token|token[]", couple="path", required=True, doc="path of a prim or property, or array of paths"
    )
    parent_path: Any = Out(type="token|token[]", couple="path", doc="parent's path, of the input's type")

    def compute(self) -> None:
        """Remove the last name."""
        path = self.path
        self.parent_path = parent_of(path) if isinstance(path, str) else tuple(map(parent_of, path))


class GraphPathNode(Node):
    """Base of nodes that output the prim path of their own graph."""

    path: str = Bound()

    def setup(self, context: Context) -> None:
        """Read the path of the graph's prim."""
        self.path = context.graph_path


class GraphTarget(GraphPathNode, type="omni.graph.nodes.GraphTarget"):
    """Prim path of the graph that contains the node."""

    target_path: Token = In(default="", doc="no effect, as in OmniGraph")
    prim_path: Token = Out(doc="path of the graph's prim")

    def compute(self) -> None:
        """Output the path."""
        self.prim_path = self.path


class GetGraphTargetPrim(GraphPathNode, type="omni.graph.nodes.GetGraphTargetPrim"):
    """The prim of the graph that contains the node."""

    prim: Target = Out(doc="prim of the graph")

    def compute(self) -> None:
        """Output the prim."""
        self.prim = (self.path,)
