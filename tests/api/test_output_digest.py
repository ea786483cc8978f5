"""The digest of a session's output: equal for equal runs in any process, different for any other message."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path

import graphengine as ge
from graphengine.messages.endpoints import EndpointClaim
from tests.other_process import in_another_process

ODOM = "/dd100_0000/odom"


def digest(ticks: int = 5) -> tuple[str, int]:
    with ge.load("dd100_flat", rays="mujoco").session() as sim:
        output = sim.digest_output()
        sim.subscribe(ODOM)
        sim.subscribe("/clock")
        sim.step(ticks)
        return output.value, output.messages


def test_equal_runs_have_equal_digests_in_another_process() -> None:
    assert digest() == in_another_process(digest)
    assert digest()[1] == 11  # two topics in five ticks, and the latched topic once


def test_more_messages_have_another_digest() -> None:
    assert digest(ticks=5)[0] != digest(ticks=6)[0]


def test_the_digest_covers_topics_and_bytes_of_messages_in_order() -> None:
    with ge.load("dd100_flat", rays="mujoco").session() as sim:
        output = sim.digest_output()
        sent: list[tuple[str, bytes]] = []

        class Copy:
            def write(self, claim: EndpointClaim, data: bytes) -> None:
                sent.append((claim.topic, data))

            def deliver(self, claim: EndpointClaim, arrived: Sequence[bytes]) -> None:
                pass

        sim._runner.network.tap(Copy())
        sim.subscribe(ODOM)
        sim.step(3)
    expected = b"".join(topic.encode() + b"\0%d\0" % len(data) + data for topic, data in sent)
    assert output.value == hashlib.blake2b(expected, digest_size=16).hexdigest()


def test_a_digest_of_everything_covers_the_messages_of_a_recording(tmp_path: Path) -> None:
    with ge.load("dd100_flat", rays="mujoco").session() as sim:
        whole = sim.digest_output(everything=True)
        sim.step(5)
    with ge.load("dd100_flat", rays="mujoco").session(record=tmp_path / "run.mcap") as sim:
        recorded = sim.digest_output()
        sim.step(5)
    assert (whole.value, whole.messages) == (recorded.value, recorded.messages)
    assert whole.messages > digest()[1]


def test_a_closed_digest_does_not_change() -> None:
    with ge.load("dd100_flat", rays="mujoco").session() as sim:
        output = sim.digest_output()
        sim.subscribe(ODOM)
        sim.step(2)
        before = output.value, output.messages
        output.close()
        output.close()
        sim.step(2)
        assert (output.value, output.messages) == before
