"""The topics that docs/guide/fleets_namespaces_tf.md lists for the place of a graph."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import graphengine as ge
from tests.cli.harness import ROOT

GUIDE = (ROOT / "docs/guide/fleets_namespaces_tf.md").read_text(encoding="utf-8")
FILES = dict(re.findall(r'^```yaml title="([^"]+)"\n(.*?)^```', GUIDE, re.MULTILINE | re.DOTALL))
ROWS = re.findall(r"^\| `([^`]+/battery)` \| `(/[^`]+)` \|", GUIDE, re.MULTILINE)


def topics(folder: Path, scene: str, **replaced: str) -> list[str]:
    """Return the topics of a scene of the guide that end with `battery`; `replaced` has the new text of a file by its stem."""
    for name, text in FILES.items():
        (folder / name).write_text(replaced.get(Path(name).stem, text), encoding="utf-8")
    return [claim.topic for claim in ge.load(folder / scene).topics if claim.topic.endswith("battery")]


def test_the_guide_has_four_places() -> None:
    assert len(ROWS) == 4


@pytest.mark.parametrize(("at", "topic"), ROWS)
def test_a_graph_at_this_place_publishes_on_this_topic(at: str, topic: str, tmp_path: Path) -> None:
    graph = re.sub(r"^at: .*$", f"at: {at}", FILES["battery.yaml"], flags=re.MULTILINE)
    assert topics(tmp_path, "carriers.yaml", battery=graph)[0] == topic


def test_a_slash_before_the_name_changes_nothing(tmp_path: Path) -> None:
    graph = FILES["battery.yaml"].replace("topicName: battery", "topicName: /battery")
    assert topics(tmp_path, "carriers.yaml", battery=graph)[0] == "/carrier_0000/battery"


def test_a_namespace_of_a_scene_belongs_to_one_prim(tmp_path: Path) -> None:
    [entry] = re.findall(r"`(namespaces: \{[^`]+\})`", GUIDE)
    scene = FILES["carriers.yaml"] + entry + "\n"
    assert sorted(topics(tmp_path, "carriers.yaml", carriers=scene))[1] == "/carrier_0001/east/battery"
