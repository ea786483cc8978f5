"""Scripts of most tests run in forks of one process that is ready; those of test_hostile and of the commands in new ones."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from graphengine.isaac.script import script_reader
from graphengine.sandbox.confinement import ProcessError
from tests.cli.conftest import graphrun as graphrun
from tests.cli.harness import Graphrun, Result

READY = """
import contextlib, gc, importlib, os, socket, sys
from graphengine.isaac.script import script_process
for name in script_process.OFFERED.split():
    with contextlib.suppress(ImportError):
        importlib.import_module(name)
gc.freeze()
asked = socket.socket(fileno=int(sys.argv.pop()))
while (received := socket.recv_fds(asked, 1, 2))[0]:
    child = os.fork()
    if not child:
        asked.close()
        os.setsid()
        for number, end in enumerate(received[1]):
            os.dup2(end, number)
            os.close(end)
        script_process.main()
    for end in received[1]:
        os.close(end)
    asked.send(bytes([os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) & 255]))
"""
"""Runs the process of a script in a fork of itself, which has imported the modules that it needs; they take 0.15 s."""
Ask = Callable[[str, bytes, float], bytes]
IN_NEW_PROCESSES = ("test_hostile", "test_commands")


@pytest.fixture(scope="session")
def ask_fork() -> Iterator[Ask]:
    ours, theirs = socket.socketpair()
    environment = {"PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "PYTHONHASHSEED": "0"}
    environment["OPENBLAS_NUM_THREADS"] = "1"
    command = [sys.executable, "-P", "-s", "-c", READY, str(theirs.fileno())]

    def ask(module: str, request: bytes, seconds: float) -> bytes:
        (reading_end, request_end), (answer_end, writing_end) = os.pipe(), os.pipe()
        socket.send_fds(ours, [b" "], [reading_end, writing_end])
        os.close(reading_end)
        os.close(writing_end)
        with ThreadPoolExecutor(1) as pool, open(answer_end, "rb") as answers:
            asking = pool.submit(write, request_end, request)
            answer = answers.read()
            asking.result()
        if code := ours.recv(1)[0]:
            raise ProcessError(f"ended with exit code {code}", answer)
        return answer

    with ours, subprocess.Popen(command, env=environment, pass_fds=[theirs.fileno()]) as ready:
        theirs.close()
        yield ask
        ours.close()
        ready.wait()


def write(end: int, request: bytes) -> None:
    with open(end, "wb") as stream:
        stream.write(request)


@pytest.fixture(autouse=True)
def scripts_in_forks(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    if request.path.stem not in IN_NEW_PROCESSES:
        monkeypatch.setattr(script_reader, "ask", request.getfixturevalue("ask_fork"))


@pytest.fixture
def imports(graphrun: Graphrun, tmp_path: Path) -> Graphrun:
    """`graphrun import` of a file, or of a text that becomes `script.py`, into the folder of the test."""

    def run(script: Path | str, *given: str) -> Result:
        if isinstance(script, str):
            (tmp_path / "script.py").write_text(script, encoding="utf-8")
            script = tmp_path / "script.py"
        return graphrun("import", str(script), "-o", str(tmp_path), *given)

    return run
