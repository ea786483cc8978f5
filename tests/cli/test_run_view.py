"""`graphrun run --view`: the page never ends a run, whether its process is slow, never ready, fails or dies."""

from __future__ import annotations

import os
import re
import signal
import socket
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

pytest.importorskip("viser", reason="the extra view is not installed")

from tests.cli.harness import ROOT, live, process
from tests.view.harness import Viewer

RUN = ("run", "dd100_flat", "--transport", "memory", "--rays", "mujoco")
SEEN = re.compile(r"see it: (http://127\.0\.0\.1:\d+/#token=\S+)\r?\n")
GATE = """import os, pathlib, sys, time
if any("page_process" in word for word in sys.orig_argv):
    gate = pathlib.Path({!r})
    while not gate.exists():
        time.sleep(0.01)
    if text := gate.read_bytes():
        os.write(2, text)
        os._exit(3)
"""
"""Makes processes of pages wait until a file exists; if it has a text, they print the text and fail."""


@pytest.fixture
def gate(tmp_path: Path) -> Path:
    return tmp_path / "gate"


@pytest.fixture
def env(gate: Path) -> Iterator[Mapping[str, str]]:
    """Environment in which the processes of pages wait."""
    (gate.parent / "sitecustomize.py").write_text(GATE.format(str(gate)), encoding="utf-8")
    with tempfile.TemporaryDirectory(prefix="graphrun-test-") as runtime:  # a short path, as sockets need
        yield {"PYTHONPATH": os.pathsep.join([str(gate.parent), str(ROOT)]), "XDG_RUNTIME_DIR": runtime}


def test_a_run_whose_page_never_starts_ends_normally(env: Mapping[str, str]) -> None:
    ended = process(*RUN, "--view", "--for", "0.5", env=env, code=0)
    assert "\n30 ticks, 0.500 s of simulation" in ended.err
    assert "see it" not in ended.err
    assert "warning" not in ended.err


def test_the_address_is_printed_by_the_run_and_by_ctl_when_the_page_is_there(
    env: Mapping[str, str], gate: Path
) -> None:
    with live(*RUN, "--rate", "1", "--view", env=env) as run:
        assert run.hear(lambda said: " Hz, " in said)
        for _ in range(2):  # the run goes on meanwhile
            assert "playing" in process("ctl", "state", env=env, code=0).out
        with live("ctl", "view", env=env, out=True) as asked:
            assert "see it" not in run.said
            gate.touch()
            assert run.hear(SEEN.search)  # type: ignore[arg-type]
            (url,) = SEEN.findall(run.said)
            assert asked.hear(lambda said: said == f"{url}\n")
        with Viewer(url).socket:
            pass
        assert run.stop(signal.SIGINT) == 0


@pytest.mark.parametrize("text", [b"\x1b[31mevil\x07 \xff\xe2\x80\xae\nsecond\n", b"x" * 500_000])
def test_a_page_that_fails_is_one_warning_without_control_characters(
    env: Mapping[str, str], gate: Path, text: bytes
) -> None:
    gate.write_bytes(text)
    warned = "the run goes on without its page; `graphrun ctl view` opens a new one\n"
    with live(*RUN, "--rate", "1", "--view", env=env) as run:
        assert run.hear(lambda said: warned in said)
        assert "playing" in process("ctl", "state", env=env, code=0).out
        assert "the process of the page has ended" in process("ctl", "view", env=env, code=1).err
        assert run.stop(signal.SIGTERM) == 0
    assert run.said.count("warning: the process of the page has ended\n") == 1
    assert len(run.said) < 5000
    assert all(character.isprintable() or character == "\n" for character in run.said)


def test_a_port_that_is_taken_is_a_warning() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with live(*RUN, "--rate", "1", "--view", "--view-port", str(port)) as run:
            assert run.hear(lambda said: f"warning: the page cannot be served on 127.0.0.1, port {port}: " in said)
            assert run.stop(signal.SIGINT) == 0
    assert " s of simulation" in run.said


@pytest.mark.parametrize(
    ("option", "value", "error"),
    [
        ("--view-port", "70000", "argument --view-port: '70000' is not a port; write a number from 0 to 65535"),
        ("--view-port", "-1", "argument --view-port: '-1' is not a port"),
        ("--view-port", "9" * 5000, "is not a port"),
        ("--view-host", "localhost", "argument --view-host: 'localhost' is not an IP address; write one such as 127"),
    ],
)
def test_an_address_that_does_not_exist_is_refused_before_the_run(option: str, value: str, error: str) -> None:
    for verb in ("run", "view"):
        assert error in process(verb, "dd100_flat", option, value, code=2).err
