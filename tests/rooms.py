"""The drawing of the rooms in CONTRIBUTING.md.

    python -m tests.rooms

writes it anew. It holds the arrows that no other arrows imply: a room may import whatever it reaches along them.
"""

from __future__ import annotations

import re
from pathlib import Path

import grimp
import networkx as nx

CONTRIBUTING = Path(__file__).resolve().parents[1] / "CONTRIBUTING.md"
_BLOCK = re.compile(r"^```mermaid\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def imports() -> nx.DiGraph[str]:
    """An edge from each room to each room that it imports, type checking and imports in functions included."""
    modules = grimp.build_graph("graphengine")
    rooms: nx.DiGraph[str] = nx.DiGraph()
    for module in modules.modules:
        for imported in modules.find_modules_directly_imported_by(module):
            pair = [name.split(".")[1] for name in (module, imported) if "." in name]
            if len(pair) == 2 and pair[0] != pair[1]:
                rooms.add_edge(*pair)
    return rooms


def drawing(rooms: nx.DiGraph[str]) -> str:
    """A Mermaid flowchart of the rooms, the highest first; rooms that import the same share a line."""
    layers = nx.topological_generations(rooms.reverse())
    order = [room for layer in reversed([*layers]) for room in sorted(layer)]
    reduced = nx.transitive_reduction(rooms)
    above: dict[tuple[str, ...], list[str]] = {}
    for room in order:
        if below := tuple(sorted(reduced[room], key=order.index)):
            above.setdefault(below, []).append(room)
    lines = [f"    {' & '.join(sources)} --> {' & '.join(below)}\n" for below, sources in above.items()]
    return "".join(["flowchart TD\n", *lines])


def kept(text: str) -> str:
    """The drawing that a text holds."""
    (found,) = _BLOCK.findall(text)
    return str(found)


if __name__ == "__main__":
    before = CONTRIBUTING.read_text(encoding="utf-8")
    CONTRIBUTING.write_text(_BLOCK.sub(f"```mermaid\n{drawing(imports())}```", before), encoding="utf-8")
