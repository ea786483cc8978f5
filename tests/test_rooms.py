"""CONTRIBUTING.md draws the rooms and their imports as they are."""

from __future__ import annotations

import re

import networkx as nx

from tests.rooms import CONTRIBUTING, drawing, imports, kept

TEXT = CONTRIBUTING.read_text(encoding="utf-8")


def test_the_drawing_has_the_rooms_and_the_arrows_that_are_there() -> None:
    assert kept(TEXT) == drawing(imports()), "`python -m tests.rooms` draws it anew"


def test_each_import_is_a_way_along_the_arrows_that_are_drawn() -> None:
    drawn: nx.DiGraph[str] = nx.DiGraph()
    for line in kept(TEXT).splitlines()[1:]:
        sources, targets = (end.strip().split(" & ") for end in line.split("-->"))
        drawn.add_edges_from((source, target) for source in sources for target in targets)
    assert nx.transitive_closure(drawn).edges >= imports().edges


def test_each_room_of_the_drawing_stands_in_the_table() -> None:
    cells = [line.split("|")[1] for line in TEXT.splitlines() if line.startswith("| `")]
    assert sorted(imports()) == sorted(re.findall(r"`(\w+)/`", " ".join(cells)))


def test_rooms_that_import_the_same_share_a_line_and_what_others_imply_is_left_out() -> None:
    rooms = nx.DiGraph([("top", "left"), ("top", "right"), ("left", "ground"), ("right", "ground"), ("top", "ground")])
    assert drawing(rooms) == "flowchart TD\n    top --> left & right\n    left & right --> ground\n"
