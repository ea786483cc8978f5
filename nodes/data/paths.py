"""Nodes that output or change prim paths (`omni.graph.nodes`)."""

from __future__ import annotations

from typing import Any

from graphengine.node import BadValueError, Bound, Context, In, Node, Out, Target, Token, Tokens


class GetPrimPath(Node, type="omni.graph.nodes.GetPrimPath"):
    """Outputs the path of a prim."""

    prim: Target = In(default=(), doc="prim whose path is output; if there are several, the first one")
    path: Any = Out(type="path", doc="path of the prim; empty if `prim` is empty")
    prim_path: Token = Out(doc="path of the prim as a token; empty if `prim` is empty")

    def compute(self) -> None:
        """Set both outputs to the path of the first prim, or to an empty string if there is no prim."""
        self.path = self.prim_path = self.prim[0] if self.prim else ""


class GetPrimPaths(Node, type="omni.graph.nodes.GetPrimPaths"):
    """Outputs the paths of prims as tokens."""

    prims: Target = In(default=(), doc="prims whose paths are output")
    prim_paths: Tokens = Out()

    def compute(self) -> None:
        """Set `primPaths` to the paths of all prims."""
        self.prim_paths = self.prims


def parent_of(path: str) -> str:
    """Return a path without its last prim or property name; a string without `/` and `.` is returned unchanged."""
    if "." in path.rpartition("/")[2]:
        return path.rpartition(".")[0]
    above, slash, _ = path.rpartition("/")
    return above or slash or path


def below(path: str, suffix: str) -> str:
    """Return a path with a relative path appended; an empty path stays empty."""
    between = "" if suffix.startswith(".") else "/"
    return f"{path.rstrip('/')}{between}{suffix}" if path and suffix else path


class AppendPath(Node, type="omni.graph.nodes.AppendPath"):
    """Appends names to a prim path: `/World` and `box` give `/World/box`."""

    path_in: Any = In(type="token|token[]", name="path", couple="path", required=True, doc="path to extend, or array")
    suffix: Token = In(default="", doc="descendant prims, a property, or both, such as `box/lid` or `box.mass`")
    path_out: Any = Out(type="token|token[]", name="path", couple="path", doc="extended path, or array of paths")

    def compute(self) -> None:
        """Set the output to the path, or to each path of the array, with the suffix appended.

        Raises:
            BadValueError: the suffix begins with a slash.
        """
        if self.suffix.startswith("/"):
            raise BadValueError("suffix", self.suffix, "names to append, without a leading /")
        path, suffix = self.path_in, self.suffix
        self.path_out = below(path, suffix) if isinstance(path, str) else tuple(below(one, suffix) for one in path)


class GetParentPath(Node, type="omni.graph.nodes.GetParentPath"):
    """Outputs the path of the parent of a prim or property, such as `/World` for `/World/box`."""

    path: Any = In(type="token|token[]", couple="path", required=True, doc="path of a prim or property, or array")
    parent_path: Any = Out(type="token|token[]", couple="path", doc="path of the parent, or array of paths")

    def compute(self) -> None:
        """Set `parentPath` to the path, or to each path of the array, without its last name."""
        path = self.path
        self.parent_path = parent_of(path) if isinstance(path, str) else tuple(map(parent_of, path))


class GraphPathNode(Node):
    """Base class of nodes that output the prim path of the graph that contains them."""

    path: str = Bound()

    def setup(self, context: Context) -> None:
        """Store the path of the graph's prim in `path`."""
        self.path = context.graph_path


class GraphTarget(GraphPathNode, type="omni.graph.nodes.GraphTarget"):
    """Outputs the prim path of the graph that contains the node."""

    target_path: Token = In(default="", doc="no effect, as in OmniGraph")
    prim_path: Token = Out(doc="path of the graph's prim")

    def compute(self) -> None:
        """Set `primPath` to the path of the graph's prim."""
        self.prim_path = self.path


class GetGraphTargetPrim(GraphPathNode, type="omni.graph.nodes.GetGraphTargetPrim"):
    """Outputs the prim of the graph that contains the node."""

    prim: Target = Out(doc="prim of the graph")

    def compute(self) -> None:
        """Set `prim` to the graph's prim."""
        self.prim = (self.path,)
