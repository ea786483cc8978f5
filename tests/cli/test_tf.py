"""`graphrun tf tree`: what is drawn, written and warned of."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import LATCHED
from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport
from tests.cli.harness import Graphrun

TF = "tf2_msgs/msg/TFMessage"


@pytest.fixture
def domain(domain_id: int) -> Domain:
    return Domain(domain_id, "OFF")


@pytest.fixture
def peer(domain: Domain) -> Iterator[DdsTransport]:
    with closing(DdsTransport(JoinOptions(domain, "peer"))) as transport:
        yield transport


@pytest.fixture
def tree(graphrun: Graphrun) -> Graphrun:
    return lambda *arguments, **ended: graphrun("tf", "tree", "-t", "0.5", "--transport", "dds", *arguments, **ended)


def frames(*edges: tuple[str, str]) -> bytes:
    zero, unit = messages.Vector3(0.0, 0.0, 0.0), messages.Quaternion(0.0, 0.0, 0.0, 1.0)
    stamped = [(messages.header(1.25, parent), child, messages.Transform(zero, unit)) for parent, child in edges]
    return messages.encode(messages.TFMessage([messages.TransformStamped(*edge) for edge in stamped]))


def latch(peer: DdsTransport, topic: str, *edges: tuple[str, str]) -> Any:
    writer = peer.writer(topic, TF, LATCHED)
    writer.write(frames(*edges))
    return writer


def test_the_tree_shows_the_broadcaster_of_each_frame(tree: Graphrun, peer: DdsTransport) -> None:
    latch(peer, "/tf_static", ("base", "laser"), ("odom", "base"))
    result = tree(code=0)
    assert result.lines == [
        "FRAME        BROADCASTER  RATE    NEWEST",
        "odom",
        "└─ base      /peer        static  1.250 s",
        "   └─ laser  /peer        static  1.250 s",
    ]
    assert result.err == "listening to /tf and /tf_static for 0.5 s\n"


def test_the_only_namespace_with_transforms_is_the_default(tree: Graphrun, peer: DdsTransport) -> None:
    latch(peer, "/robot/tf_static", ("base", "laser"))
    assert "listening to /robot/tf and /robot/tf_static" in tree().err
    result = tree("--namespace", "robot")
    assert (result.code, result.lines[2]) == (0, "└─ laser  /peer        static  1.250 s")


def test_of_several_namespaces_one_must_be_given(tree: Graphrun, peer: DdsTransport) -> None:
    latch(peer, "/a/tf_static", ("base", "laser"))
    latch(peer, "/b/tf_static", ("base", "camera"))
    tree(
        code=1,
        out="",
        err="error: transforms are published in several namespaces\nchoose one with --namespace: /a, /b\n",
    )
    assert "camera" in tree("--namespace", "/b").out


def test_an_empty_tree_is_reported_with_namespaces_that_have_transforms(tree: Graphrun, peer: DdsTransport) -> None:
    latch(peer, "/a/tf_static", ("base", "laser"))
    result = tree("--namespace", "b", code=1, out="")
    assert result.err.endswith(
        "error: no transforms on /b/tf and /b/tf_static within 0.5 s\nnamespaces in which there are publishers: /a\n"
    )


def test_faults_of_the_tree_are_warnings(tree: Graphrun, peer: DdsTransport, domain: Domain) -> None:
    latch(peer, "/tf_static", ("odom", "base"), ("chassis", "laser"))
    other = DdsTransport(JoinOptions(domain, "other"))
    latch(other, "/tf_static", ("map", "base"))
    other.writer("/tf_static", TF, QoS())
    result, strict = tree(), tree("--strict")
    other.close()
    assert result.err.splitlines()[1:] == [
        "warning: the tree is in 3 pieces, with the roots chassis, map, odom",
        "warning: base has 2 parents: map (by /other), odom (by /peer)",
        "warning: /other publishes /tf_static with durability volatile, so tf2 does not receive it",
    ]
    assert (result.code, strict.code) == (0, 1)


def test_frames_cannot_steer_a_terminal(tree: Graphrun, peer: DdsTransport) -> None:
    latch(peer, "/tf_static", ("odom", "ba\nse"), ("map", "ba\nse"))
    result = tree()
    assert result.lines[2].startswith("└─ ba\ufffdse")
    assert len(result.lines) == 5


@pytest.mark.parametrize("name", ["frames.dot", "frames.gv", "frames.txt"])
def test_the_tree_can_be_written_to_a_file(tree: Graphrun, peer: DdsTransport, tmp_path: Path, name: str) -> None:
    latch(peer, "/tf_static", ("odom", "base"))
    victim = tmp_path / "victim"
    victim.touch()
    (tmp_path / name).symlink_to(victim)
    assert tree("-o", str(tmp_path / name)).out == ""
    assert victim.read_bytes() == b""
    text = (tmp_path / name).read_text(encoding="utf-8")
    if name.endswith("txt"):
        assert text.startswith("FRAME    BROADCASTER  RATE    NEWEST\nodom\n└─ base  /peer ")
    else:
        assert '  "odom" -> "base" [label="Broadcaster: /peer\\n' in text


def test_a_picture_is_drawn_by_the_dot_that_is_found(
    tree: Graphrun, peer: DdsTransport, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    latch(peer, "/tf_static", ("odom", "base"))
    dot = tmp_path / "dot"
    dot.write_text('#!/bin/sh\necho "$@"\ncat\n', encoding="utf-8")
    dot.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    assert tree("-o", str(tmp_path / "frames.svg")).code == 0
    drawn = (tmp_path / "frames.svg").read_text(encoding="utf-8").splitlines()
    assert drawn[:2] == ["-Tsvg", "digraph frames {"]


@pytest.mark.parametrize(
    ("name", "remedy"),
    [
        ("frames.png", "or install graphviz"),
        ("frames.jpg", "end in one of .txt, .dot"),
    ],
)
def test_a_file_that_cannot_be_written_is_refused_at_once(
    tree: Graphrun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, remedy: str
) -> None:
    monkeypatch.setattr(shutil, "which", lambda program: None)
    result = tree("-o", str(tmp_path / name), code=2, out="")
    assert remedy in result.err
