"""Actions in recordings: goals, feedback and results are replayed, also for a session that had peers on a network."""

from __future__ import annotations

import uuid
from collections.abc import Callable
from pathlib import Path

from graphengine.messages.goals import SUCCEEDED
from tests.action_graph import BOTH, CLIENT, FIBONACCI, SERVER
from tests.action_peer import ActionPeer, ActionServerPeer
from tests.cli.harness import Graphrun
from tests.recording.harness import Run, put, record

OFFERED, SENDING, ALONE = f"graph: offered\n{SERVER}", f"graph: sending\n{CLIENT}", f"graph: both\n{BOTH}"
AGAIN = SENDING.replace("Once.once -> Client.execIn", "Tick.tick -> Client.execIn")


def pursuing() -> Callable[[int, Run], None]:
    """A client of another program: one goal succeeds, one is cancelled, and one is aborted by a stop."""
    peers: list[ActionPeer] = []

    def before(tick: int, run: Run) -> None:
        if not peers:
            peers.append(ActionPeer(run.transport, "/fibonacci", FIBONACCI))
        goal = uuid.UUID(int=tick)
        match tick:
            case 3 | 15 | 25:
                peers[0].send(goal, order=tick)
            case 4 | 16 | 26:
                peers[0].ask_result(uuid.UUID(int=tick - 1))
            case 17:
                peers[0].cancel(uuid.UUID(int=15))
            case 28:
                run.session.stop()

    return before


def serving() -> Callable[[int, Run], None]:
    """A server of another program, which succeeds two ticks after a goal."""
    peers: list[ActionServerPeer] = []

    def before(tick: int, run: Run) -> None:
        if not peers:
            peers.append(ActionServerPeer(run.transport, "/fibonacci", FIBONACCI))
        if tick == 4:
            peers[0].answer_goal()
        if tick == 5:
            peers[0].say(peers[0].goals[0], sequence=[0])
        if tick == 8:
            peers[0].answer_result(SUCCEEDED, sequence=[0, 1])

    return before


def replayed(graphrun: Graphrun, path: Path) -> None:
    result = graphrun("replay", str(path))
    assert (result.code, result.err) == (0, "")
    assert result.out.startswith("identical: ")


def test_goals_of_a_client_are_replayed(graphrun: Graphrun, tmp_path: Path) -> None:
    path = tmp_path / "out.mcap"
    record(path, 40, put(tmp_path / "offered.yaml", OFFERED), before=pursuing())
    replayed(graphrun, path)


def test_messages_of_a_server_are_replayed(graphrun: Graphrun, tmp_path: Path) -> None:
    path = tmp_path / "out.mcap"
    record(path, 20, put(tmp_path / "sending.yaml", SENDING), before=serving())
    replayed(graphrun, path)


def test_a_client_and_a_server_of_one_graph_are_replayed(graphrun: Graphrun, tmp_path: Path) -> None:
    scene, files = put(tmp_path / "both.yaml", ALONE), [tmp_path / name for name in ("one.mcap", "two.mcap")]
    for path in files:
        record(path, 20, scene)
    replayed(graphrun, files[0])
    assert files[0].read_bytes() == files[1].read_bytes()


def test_uuids_of_goals_that_left_the_process_differ_in_each_run_and_are_replayed(
    graphrun: Graphrun, tmp_path: Path, domain_id: int
) -> None:
    scene, files = put(tmp_path / "sending.yaml", AGAIN), [tmp_path / name for name in ("one.mcap", "two.mcap")]
    for path in files:
        ran = graphrun("run", str(scene), "--for", "0.05s", "--record", str(path), "--transport", "dds")
        assert ran.code == 0
        replayed(graphrun, path)
    assert files[0].read_bytes() != files[1].read_bytes()
