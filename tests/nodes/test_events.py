"""Impulses, keys, the start of plays and messages for people: alone, in graphs, and in a replay."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from graphengine.format.errors import UsageError
from graphengine.node.keys import KEYS, keys_of
from graphengine.nodes.action.keyboard import OnKeyboardInput, ReadKeyboardState
from graphengine.nodes.action.logging import LogMessage, PrintText
from graphengine.nodes.action.stage_events import OnClosing, OnImpulseEvent, OnLoaded, OnStageEvent
from graphengine.runtime import commands
from graphengine.runtime.inbox import ExternalInputs
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, checked, ready

# OnImpulseEvent

IMPULSE = """
at: /World/graph
nodes: {Impulse: OnImpulseEvent, Count: Counter}
connections:
  - Impulse.execOut -> Count.execIn
"""


def test_an_impulse_fires_in_the_next_tick_and_once(context: RecordingContext) -> None:
    node = ready(OnImpulseEvent, context)
    fired = []
    for posted in (False, True, False):
        if posted:
            context.mailbox("impulse:/World/graph/node").post()
        context.tick()
        fired.append(node.compute() == node.exec_out)
    assert fired == [False, True, False]


@pytest.mark.parametrize("name", ["Impulse", "graph/Impulse", "/World/graph/Impulse"])
def test_impulses_before_one_tick_are_one(play: Player, name: str) -> None:
    playing = play.graph(IMPULSE)
    for _ in range(3):
        playing.command("impulse", node=name)
    playing.tick(3)
    assert playing.node("Count").count == 1
    commands.parse("impulse", {"node": name}).apply(playing.session)
    playing.tick()
    assert playing.node("Count").count == 2


def test_more_impulses_than_a_queue_holds_fire_once(play: Player) -> None:
    playing = play.graph(IMPULSE)
    for _ in range(1001):
        playing.command("impulse", node="Impulse")
    playing.tick()
    assert playing.node("Count").count == 1


def test_a_stop_discards_impulses(play: Player) -> None:
    playing = play.graph(IMPULSE).tick()
    playing.command("impulse", node="Impulse")
    playing.session.stop()
    playing.tick(2)
    assert playing.node("Count").count == 0


@pytest.mark.parametrize("name", ["Impuls", "/", "pulse", "World/graph"])
def test_the_error_of_an_impulse_for_an_unknown_node_lists_the_nodes(play: Player, name: str) -> None:
    playing = play.graph(IMPULSE)
    with pytest.raises(UsageError, match="/World/graph/Impulse"):
        playing.command("impulse", node=name)


def test_the_error_of_an_impulse_that_matches_two_nodes_names_both(play: Player) -> None:
    playing = play.graph(IMPULSE.replace("Count: Counter", "OtherImpulse: OnImpulseEvent, Count: Counter"))
    with pytest.raises(UsageError, match="no OnImpulseEvent node 'mpulse'"):
        playing.command("impulse", node="mpulse")
    playing.command("impulse", node="OtherImpulse")


# OnKeyboardInput, ReadKeyboardState


def typed(node: OnKeyboardInput, context: RecordingContext, *steps: str) -> list[str]:
    """What fires when in each tick the named keys are down."""
    fired, down = [], set[str]()
    for step in steps:
        now = set(step.split())
        context.services.keys.press(now - down)
        context.services.keys.release(down - now)
        down = now
        context.tick()
        result = node.compute()
        fired.append({node.pressed: "pressed", node.released: "released", None: ""}[result])
    return fired


def test_a_key_is_pressed_once_and_released_once(context: RecordingContext) -> None:
    node = ready(OnKeyboardInput, context, key_in="W")
    assert typed(node, context, "", "W", "W A", "A", "") == ["", "pressed", "", "released", ""]
    assert (node.is_pressed, node.key_out) == (False, "W")


def test_modifiers_must_be_held_before_the_key_and_the_first_release_ends_the_press(context: RecordingContext) -> None:
    node = ready(OnKeyboardInput, context, key_in="D", ctrl_in=True, shift_in=True)
    steps = ["D", "D LeftControl LeftShift", "LeftControl LeftShift", "D LeftControl RightShift", "D LeftControl", ""]
    assert typed(node, context, *steps) == ["", "", "", "pressed", "released", ""]


def test_a_key_pressed_and_released_between_ticks_is_held_for_one_tick(context: RecordingContext) -> None:
    node = ready(OnKeyboardInput, context, key_in="Space")
    context.services.keys.press(["Space"])
    context.services.keys.release(["Space"])
    fired = []
    for _ in range(3):
        context.tick()
        fired.append(node.compute())
    assert fired == [node.pressed, node.released, None]


def test_the_state_of_a_key_is_read(context: RecordingContext) -> None:
    node = ready(ReadKeyboardState, context, key="S")
    context.services.keys.press(["S", "RightShift", "LeftAlt"])
    context.tick()
    node.compute()
    assert (node.is_pressed, node.shift_out, node.alt_out, node.ctrl_out) == (True, True, True, False)
    context.services.keys.release(["S"])
    context.tick()
    node.compute()
    assert node.is_pressed is False


@pytest.mark.parametrize(
    ("sent", "keys"),
    [
        ("w", ("W",)),
        ("W", ("LeftShift", "W")),
        ("\x17", ("LeftControl", "W")),
        ("7", ("Key7",)),
        (" ", ("Space",)),
        ("\r", ("Enter",)),
        ("up", ("Up",)),
        ("ß", ()),
        ("é", ()),
        ("\x00", ()),
        ("", ()),
        ("٣", ()),
    ],
)
def test_characters_of_a_terminal_are_translated_to_keys(sent: str, keys: tuple[str, ...]) -> None:
    assert keys_of(sent) == keys
    assert set(keys) <= set(KEYS)


KEYBOARD = """
nodes: {Key: {type: OnKeyboardInput, inputs: {keyIn: W}}, Down: Counter, Up: Counter}
connections: [Key.pressed -> Down.execIn, Key.released -> Up.execIn]
"""


def test_keys_reach_a_graph_by_commands(play: Player) -> None:
    playing = play.graph(KEYBOARD)
    assert playing.session.services.keys.asked
    commands.parse("press", {"keys": "W"}).apply(playing.session)
    playing.tick(3)
    commands.parse("release", {"keys": ["W"]}).apply(playing.session)
    playing.tick(2)
    assert (playing.node("Down").count, playing.node("Up").count) == (1, 1)
    with pytest.raises(UsageError, match="no key 'w'"):
        playing.command("press", keys="w")


class Notes(ExternalInputs):
    """An inbox that remembers what a recorder would take down."""

    exact = False

    def __init__(self) -> None:
        self.commands: list[tuple[str, Any]] = []

    def command(self, name: str, arguments: Any) -> None:
        self.commands.append((name, arguments))


def test_recorded_keys_and_impulses_can_be_replayed(play: Player) -> None:
    playing = play.graph(KEYBOARD.replace("Down:", "Impulse: OnImpulseEvent, Down:"))
    playing.session.inbox = notes = Notes()
    playing.command("press", keys="W")
    playing.command("impulse", node="Impulse")
    playing.command("release", keys="W")
    assert [name for name, _ in notes.commands] == ["press", "impulse", "release"]
    assert all(commands.COMMANDS[name].recorded for name, _ in notes.commands)
    again = play.graph((play.folder / "graph.yaml").read_text("utf-8").partition("graph: graph\n")[2])
    for name, arguments in notes.commands:
        commands.parse(name, arguments).apply(again.session)
    again.tick(2)
    assert (again.node("Down").count, again.node("Up").count) == (1, 1)


# OnStageEvent, OnLoaded, OnClosing

PLAYS = """
nodes:
  Start: {type: OnStageEvent, inputs: {eventName: Simulation Start Play}}
  Loaded: OnLoaded
  Starts: Counter
  Loads: Counter
connections: [Start.execOut -> Starts.execIn, Loaded.execOut -> Loads.execIn]
"""


def test_a_start_event_fires_in_the_first_tick_of_every_play_and_not_after_a_pause(play: Player) -> None:
    playing = play.graph(PLAYS).tick(3)
    playing.session.pause()
    playing.tick(2)
    assert (playing.node("Starts").count, playing.node("Loads").count) == (1, 1)
    playing.session.stop()
    playing.tick(3)
    assert (playing.node("Starts").count, playing.node("Loads").count) == (1, 0)


def test_outside_a_graph_a_start_event_fires_once_a_play(context: RecordingContext) -> None:
    node, loaded = ready(OnStageEvent, context), ready(OnLoaded, context)
    context.tick()
    assert (node.compute(), loaded.compute()) == (node.exec_out, loaded.exec_out)
    context.tick()
    assert (node.compute(), loaded.compute()) == (None, None)
    context.stop(node, loaded)
    context.tick()
    assert (node.compute(), loaded.compute()) == (node.exec_out, None)


STOPS = ("OmniGraph Stop Play", "Simulation Stop Play", "Animation Stop Play")


@pytest.mark.parametrize(("name", "stops"), [*((name, True) for name in STOPS), ("Simulation Start Play", False)])
def test_outside_a_graph_a_stop_event_fires_only_at_the_end_of_play(name: str, stops: bool) -> None:
    context = RecordingContext()
    node = ready(OnStageEvent, context, event_name=name)
    context.tick()
    assert node.compute() == (None if stops else node.exec_out)
    assert node.at_stop() == (node.exec_out if stops else None)


def test_outside_a_graph_on_closing_fires_only_before_the_graph_is_closed(context: RecordingContext) -> None:
    node = ready(OnClosing, context)
    context.tick()
    assert (node.compute(), node.at_close()) == (None, node.exec_out)


def test_a_message_published_at_a_stop_has_the_time_of_the_last_tick(play: Player) -> None:
    playing = play.graph(
        """
        nodes:
          Stop: {type: OnStageEvent, inputs: {eventName: Simulation Stop Play}}
          Closing: OnClosing
          Time: IsaacReadSimulationTime
          Stopped: {type: ROS2PublishClock, inputs: {topicName: stopped}}
          Closed: {type: ROS2PublishClock, inputs: {topicName: closed}}
        connections:
          - Stop.execOut -> Stopped.execIn
          - Closing.execOut -> Closed.execIn
          - Time.simulationTime -> Stopped.timeStamp
          - Time.simulationTime -> Closed.timeStamp
        """
    ).tick(30)
    assert playing.published("/stopped") == []
    playing.session.stop()
    playing.tick(60)
    playing.session.end()
    times = [[m.clock.sec + m.clock.nanosec / 1e9 for m in playing.published(t)] for t in ("/stopped", "/closed")]
    assert times == [[0.5, 1.0], [1.0]]


def test_the_check_reports_an_event_that_never_occurs(tmp_path: Path) -> None:
    (finding,) = checked(tmp_path, PLAYS.replace("Simulation Start Play", "Saved")).items
    assert (finding.code, finding.message) == ("W101", "Start never fires: 'Saved' is an event of the editor")


# LogMessage, PrintText


@pytest.mark.parametrize(
    ("level", "severity"), [("Verbose", "info"), ("Info", "info"), ("Warn", "warning"), ("Error", "error")]
)
def test_a_message_is_logged_with_its_severity(level: str, severity: str, context: RecordingContext) -> None:
    ready(LogMessage, context, message="at the dock", log_level=level).compute()
    assert context.logged == [(severity, "at the dock")]


@pytest.mark.parametrize("cls", [LogMessage, PrintText])
def test_an_unknown_level_from_a_wire_is_an_error(cls: Any) -> None:
    node = ready(cls, RecordingContext())
    node.log_level = "Loud"
    with pytest.raises(ValueError, match="logLevel must be one of Verbose, Info, Warn, Warning, Error, it is 'Loud'"):
        node.compute()


def test_in_a_graph_a_repeated_message_is_printed_once(play: Player) -> None:
    playing = play.graph(
        """
        nodes: {Tick: OnPlaybackTick, Log: {type: LogMessage, inputs: {message: at the dock, logLevel: Warn}}}
        connections: [Tick.tick -> Log.execIn]
        """
    ).tick(3)
    assert [line for line in playing.complaints if "at the dock" in line] == playing.complaints[:1]


def test_in_a_graph_the_state_of_a_key_is_read_and_reset_at_a_stop(play: Player) -> None:
    playing = play.graph(
        """
        nodes:
          Tick: OnPlaybackTick
          Key: {type: ReadKeyboardState, inputs: {key: W}}
          Count: {type: Counter}
          Held: Branch
        connections: [Tick.tick -> Held.execIn, Key.isPressed -> Held.condition, Held.execTrue -> Count.execIn]
        """
    )
    playing.command("press", keys="W")
    playing.tick(3)
    playing.command("release", keys="W")
    playing.tick(2)
    assert playing.node("Count").count == 3
    playing.command("press", keys="W")
    playing.tick()
    playing.session.stop()
    assert not playing.node("Key").is_pressed


def test_print_text_logs_its_text(context: RecordingContext) -> None:
    ready(PrintText, context, text="at the dock", log_level="Warning", to_screen=True).compute()
    assert context.logged == [("warning", "at the dock")]
