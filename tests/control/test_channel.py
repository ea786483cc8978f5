"""The socket by which other programs of the same user reach a run."""

from __future__ import annotations

import contextlib
import json
import os
import socket
import stat
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from graphengine.control import channel as channels
from graphengine.control import lines, runs
from graphengine.control.channel import Channel
from graphengine.control.client import Client, find
from graphengine.format import runtime_folder as format_folder
from graphengine.format.errors import ControlError, UsageError
from tests.control.conftest import MakeTicking
from tests.control.harness import Controlled, controlled
from tests.waiting import PATIENCE

Runtime = dict[str, str]


@contextlib.contextmanager
def reachable(ticking: MakeTicking, runtime: Runtime, name: str = "hall") -> Iterator[tuple[Controlled, Channel]]:
    """A session that is paused, and can be reached."""
    with controlled(ticking().session, paused=True) as run, Channel(run.queue, name, runtime) as channel:
        yield run, channel


def spoken(path: Path, data: bytes) -> bytes:
    """What is answered to a stranger until the end of the connection."""
    with runs.connect(path) as stranger:
        stranger.settimeout(PATIENCE)
        with contextlib.suppress(OSError):  # who is hung up on may find out while sending, and still reads the answer
            stranger.sendall(data)
            stranger.shutdown(socket.SHUT_WR)
        answer = b""
        with contextlib.suppress(ConnectionResetError):
            while more := stranger.recv(65536):
                answer += more
    return answer


def test_a_client_can_send_any_number_of_requests(ticking: MakeTicking, runtime: Runtime) -> None:
    with reachable(ticking, runtime), Client(find(environment=runtime)) as client:
        assert client.ask("step", {"ticks": 3}) is None
        assert client.ask("state")["tick"] == 3
        with pytest.raises(ControlError, match="step: ticks: "):
            client.ask("step", {"ticks": -1})
        assert client.ask("state")["tick"] == 3


def test_several_clients_get_responses_at_the_same_time(ticking: MakeTicking, runtime: Runtime) -> None:
    with reachable(ticking, runtime):
        entry = find(environment=runtime)
        with Client(entry) as one, Client(entry) as other:
            one.ask("step")
            assert other.ask("state") == one.ask("state")


def test_requests_and_responses_are_single_lines(ticking: MakeTicking, runtime: Runtime) -> None:
    with reachable(ticking, runtime) as (_, channel):
        asked = b'{"command": "step", "arguments": {"ticks": 2}}\n{"command": "stp"}\n{"command": "state"}\n'
        done, refused, state = map(json.loads, spoken(channel.path, asked).splitlines())
    assert done == {"result": None}
    assert refused == {"error": "no command 'stp'\n  did you mean 'step' or 'stop'?"}
    assert state["result"]["tick"] == 2


@pytest.mark.parametrize(
    "garbage",
    [
        b"\x80\x05\x95 pickles are not read\n",
        b"GET / HTTP/1.1\r\n\r\n",
        b"[]\n",
        b"null\n",
        b'"play"\n',
        b"{}\n",
        b'{"command": 1}\n',
        b'{"command": "play", "arguments": []}\n',
        b'{"command": "play", "shell": "rm"}\n',
        b"[" * 90_000 + b"\n",
        b"x" * (lines.MAX_REQUEST + 70_000),
        b'{"command": "play"}',
    ],
)
def test_only_the_client_with_a_malformed_request_is_disconnected(
    ticking: MakeTicking, runtime: Runtime, garbage: bytes
) -> None:
    with reachable(ticking, runtime) as (run, channel), Client(find(environment=runtime)) as client:
        assert spoken(channel.path, garbage) == b""
        assert client.ask("state")["state"] == "paused"
        assert run.error is None


def test_a_client_that_sends_half_a_line_is_disconnected(
    ticking: MakeTicking, runtime: Runtime, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lines, "PATIENCE", 0.01)
    with reachable(ticking, runtime) as (_, channel), runs.connect(channel.path) as stranger:
        stranger.settimeout(PATIENCE)
        stranger.sendall(b'{"command": ')
        assert stranger.recv(1) == b""


def test_a_line_that_arrives_byte_by_byte_has_the_same_timeout(monkeypatch: pytest.MonkeyPatch) -> None:
    class Dripping:
        """A connection that takes a second a byte."""

        now = 0.0

        def settimeout(self, seconds: float | None) -> None:
            pass

        def recv(self, size: int) -> bytes:
            self.now += 1.0
            return b"x"

    drip = Dripping()
    monkeypatch.setattr("graphengine.control.lines.time.monotonic", lambda: drip.now)
    with pytest.raises(lines.BadLineError):
        lines.Lines(drip).receive(lines.MAX_REQUEST)  # type: ignore[arg-type]
    assert drip.now <= lines.PATIENCE + 2.0


def test_idle_clients_do_not_block_new_clients(ticking: MakeTicking, runtime: Runtime) -> None:
    with reachable(ticking, runtime) as (_, channel), contextlib.ExitStack() as crowd:
        entry = runs.Entry("hall", os.getpid(), channel.path)
        busy = crowd.enter_context(Client(entry))
        first = crowd.enter_context(Client(entry))
        for _ in range(channels.MAX_CLIENTS):
            last = crowd.enter_context(Client(entry))
            assert busy.ask("state")["tick"] == 0
        assert last.ask("state")["tick"] == 0  # by now all of them were accepted
        with pytest.raises(ControlError, match="this client was idle the longest, and there are more than 32 clients"):
            first.ask("state")
        assert [found.path for found in runs.running(runtime)] == [channel.path]


def test_if_all_clients_wait_for_responses_the_next_client_is_refused_with_the_reason(
    ticking: MakeTicking, runtime: Runtime, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(channels, "MAX_CLIENTS", 1)
    waiting, answered = threading.Event(), threading.Event()

    def answer(*_: object) -> dict[str, object]:
        waiting.set()
        assert answered.wait(PATIENCE)
        return {"result": 1}

    with reachable(ticking, runtime) as (_, channel):
        monkeypatch.setattr(channel, "_answer", answer)
        entry = runs.Entry("hall", os.getpid(), channel.path)
        with Client(entry) as first, ThreadPoolExecutor(1) as pool:
            asked = pool.submit(first.ask, "state")
            assert waiting.wait(PATIENCE)
            with Client(entry) as second, pytest.raises(ControlError, match="1 clients are waiting for responses"):
                second.ask("state")
            answered.set()
            assert asked.result(PATIENCE) == 1


def test_without_a_thread_a_client_is_refused_with_the_reason_but_not_the_next(
    ticking: MakeTicking, runtime: Runtime, monkeypatch: pytest.MonkeyPatch
) -> None:
    start = threading.Thread.start

    def fail(thread: threading.Thread) -> None:
        if thread.name == "control client":
            monkeypatch.setattr(threading.Thread, "start", start)
            raise RuntimeError("can't start new thread")
        start(thread)

    with reachable(ticking, runtime) as (_, channel):
        monkeypatch.setattr(threading.Thread, "start", fail)
        assert json.loads(spoken(channel.path, b"")) == {"error": "can't start new thread"}
        assert b"result" in spoken(channel.path, b'{"command": "state"}\n')


def test_close_sends_outstanding_responses(ticking: MakeTicking, runtime: Runtime) -> None:
    run = Controlled(ticking().session, paused=True)
    with Channel(run.queue, "hall", runtime), Client(find(environment=runtime)) as client:
        assert client.ask("quit") is None
        run.end()
        with pytest.raises(ControlError, match="the run has ended"):
            client.ask("state")


# Which runs there are


def test_the_socket_is_private_to_its_user_and_removed_at_the_end(ticking: MakeTicking, runtime: Runtime) -> None:
    with reachable(ticking, runtime, "my scene/1") as (_, channel):
        assert channel.path.name == f"my_scene_1.{os.getpid()}"
        assert stat.S_IMODE(channel.path.parent.stat().st_mode) == 0o700
        assert [entry.path for entry in runs.running(runtime)] == [channel.path]
    assert list(channel.path.parent.iterdir()) == []


def test_the_next_search_removes_the_socket_of_a_killed_run(ticking: MakeTicking, runtime: Runtime) -> None:
    left = format_folder.folder(runtime) / "killed.1"
    with socket.socket(socket.AF_UNIX) as killed:
        killed.bind(str(left))
    with reachable(ticking, runtime):
        assert find(environment=runtime).name == "hall"
    assert not left.exists()


def test_listing_the_running_sessions_keeps_other_files_in_their_folder(runtime: Runtime) -> None:
    other = format_folder.folder(runtime) / "notes.txt"
    other.write_text("mine", encoding="utf-8")
    assert runs.running(runtime) == []
    assert other.exists()


def test_with_several_runs_a_name_is_required(ticking: MakeTicking, runtime: Runtime) -> None:
    with reachable(ticking, runtime, "hall"), reachable(ticking, runtime, "yard"):
        with pytest.raises(UsageError) as caught:
            find(environment=runtime)
        listed = "".join(f"\n  --run {os.getpid()}   {name}" for name in ("hall", "yard"))
        assert str(caught.value) == f"there are 2 runs; choose one{listed}"
        assert find("yard", runtime).name == "yard"
        with pytest.raises(ControlError, match=r"there is no run 'yarn'; did you mean 'yard'\?"):
            find("yarn", runtime)


def test_without_a_run_the_error_says_so(runtime: Runtime) -> None:
    with pytest.raises(ControlError, match="no run to control") as caught:
        find(environment=runtime)
    assert str(caught.value).endswith(f"\n  looked in {runtime['XDG_RUNTIME_DIR']}/graphrun")


@pytest.mark.parametrize("kind", ["open to others", "a link", "a file"])
def test_a_folder_that_other_users_can_access_is_refused(runtime: Runtime, kind: str) -> None:
    folder = Path(runtime["XDG_RUNTIME_DIR"]) / "graphrun"
    if kind == "a link":
        folder.symlink_to(runtime["XDG_RUNTIME_DIR"])
    elif kind == "a file":
        folder.write_bytes(b"")
    else:
        folder.mkdir()
        folder.chmod(0o777)
    with pytest.raises(ControlError, match="must be a folder that you own"):
        format_folder.folder(runtime)


@pytest.mark.parametrize("runtime_folder", ["", "relative", "/nowhere/at/all"])
def test_without_a_runtime_folder_the_sockets_are_in_the_temporary_folder(
    runtime: Runtime, monkeypatch: pytest.MonkeyPatch, runtime_folder: str
) -> None:
    monkeypatch.setattr("tempfile.tempdir", runtime["XDG_RUNTIME_DIR"])
    monkeypatch.setattr(format_folder, "RUNTIME", "/nowhere")
    folder = format_folder.folder({"XDG_RUNTIME_DIR": runtime_folder})
    assert folder == Path(runtime["XDG_RUNTIME_DIR"]) / f"graphrun-{os.getuid()}"
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


def test_a_process_without_the_variable_finds_the_same_runs(
    ticking: MakeTicking, runtime: Runtime, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(format_folder, "RUNTIME", runtime["XDG_RUNTIME_DIR"])
    users = Path(runtime["XDG_RUNTIME_DIR"]) / f"{os.getuid()}"
    users.mkdir(mode=0o700)
    with controlled(ticking().session, paused=True) as run:
        with Channel(run.queue, "hall", {"XDG_RUNTIME_DIR": str(users)}):
            assert find("hall", {}).pid == os.getpid()
        with Channel(run.queue, "hall", {}):
            assert find("hall", {"XDG_RUNTIME_DIR": str(users)}).pid == os.getpid()


def test_a_too_long_path_of_a_socket_is_an_error(ticking: MakeTicking, runtime: Runtime) -> None:
    long = Path(runtime["XDG_RUNTIME_DIR"]) / ("x" * 100)
    long.mkdir()
    with controlled(ticking().session, paused=True) as run, pytest.raises(ControlError, match="too long"):
        Channel(run.queue, "hall", {"XDG_RUNTIME_DIR": str(long)})
    assert list((long / "graphrun").iterdir()) == []
