"""`graphrun nav2 goals`: send goals to Nav2 and measure how well the robot reaches them."""

from __future__ import annotations

import argparse
import contextlib
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from graphengine.cli import terminal
from graphengine.cli.common import clean, table
from graphengine.cli.live import FEEDBACK, POLL, Live, absolute_namespace, add_live_arguments, show
from graphengine.cli.options import add_flag, add_value
from graphengine.cli.quantities import angle, duration, number
from graphengine.format.errors import ControlError, TransportError, UsageError
from graphengine.format.wording import listing

if TYPE_CHECKING:
    from graphengine.bringup.navigation.goal_list import NavigationGoal
    from graphengine.bringup.navigation.navigator import Progress
    from graphengine.bringup.navigation.outcome import Outcome
    from graphengine.bringup.navigation.true_poses import TruePoses

CLOCK_PATIENCE = 5.0
"""Wall time to wait for the first message on /clock, s."""
SAME_TIME = 5.0
"""Maximum difference between the simulation time of a run and /clock, s. If it is larger, another run publishes /clock."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun nav2 goals` to its parser."""
    what = "pose in the frame map, 'X Y [YAW]' in m and rad (or as 90deg); or a YAML file with goals, such as"
    what += " goals: [{x: 1, y: 2, yaw: 0, name: door}]"
    add_value(parser, "goals", "GOAL|FILE", what, nargs="+")
    add_value(parser, "--namespace", "NAME", "namespace of the robot (default: that of the only Nav2 on the network)")
    patience = "simulation time after which a goal is canceled (default 300s)"
    add_value(parser, "--patience", "TIME", patience, type=duration, default=300.0)
    wait = "maximum wall time to wait until Nav2 appears, and again until it accepts the first goal (default 60s)"
    add_value(parser, "--wait", "TIME", wait, type=duration, default=60.0)
    add_flag(parser, "--no-initial-pose", "do not publish the robot's true pose on `initialpose` before the first goal")
    add_value(parser, "--run", "NAME|PID", "run that simulates the robot (default: the only one)", default="")
    add_value(parser, "--junit", "FILE", "also write the results to this file as JUnit XML", type=Path)
    parser.epilog = (
        "The true poses of the robot come from the control channel of the run, as for `graphrun ctl`. Ctrl-C cancels the goal. "
        "The exit code is 0 if all goals were reached, else 1. --transport dds reaches Nav2 only if it uses Cyclone DDS; "
        "--transport rclpy reaches Nav2 on the RMW of the sourced ROS 2."
    )
    add_live_arguments(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Send the goals and print a table of their outcomes; return 0 if the robot reached all goals, else 1."""
    from graphengine.bringup.navigation.initial_pose import give_initial_pose, has_listener
    from graphengine.bringup.navigation.navigator import ACTION, Navigator
    from graphengine.bringup.navigation.outcome import RESET, Outcome, rows, write_junit

    goals, outcomes = [goal for text in arguments.goals for goal in _read(text)], list[Outcome]()
    with Live(arguments) as live:
        action = _action(live, arguments)
        namespace = action.removesuffix(f"/{ACTION}")
        own_clock = _heard_clock(live)
        with _truth(arguments.run, namespace, own_clock) as truth:
            clock = own_clock or _other_clock(truth)

            def localize() -> None:
                if truth is None or arguments.no_initial_pose or not has_listener(live.transport, namespace):
                    return
                _say(f"publishing the true pose on {namespace}/initialpose")
                if not give_initial_pose(live.transport, namespace, truth, clock):
                    _say(f"warning: the localization of {namespace or '/'} did not confirm the initial pose")

            localize()
            navigator = Navigator(
                live.transport,
                action,
                clock,
                truth,
                live.definitions,
                patience=arguments.patience,
                activation=arguments.wait,
                say=_say,
            )
            unsent = "after an error"
            try:
                for place, goal in enumerate(goals, 1):
                    if outcomes and outcomes[-1].result == RESET:
                        localize()
                    for near in truth.near(goal.x, goal.y) if truth is not None else ():
                        _say(f"goal {place}/{len(goals)} ({goal.label}): {near}")
                    outcomes.append(_drive(navigator.go, goal, f"{place}/{len(goals)}"))
            except KeyboardInterrupt:
                unsent = "after Ctrl-C"
                outcomes.append(Outcome(goal, "canceled", "by Ctrl-C"))
                raise
            finally:
                outcomes += [Outcome(goal, "not sent", unsent) for goal in goals[len(outcomes) :]]
                show(table(rows(outcomes)))
                show(f"{sum(outcome.reached for outcome in outcomes)} of {len(outcomes)} goals reached")
                if arguments.junit is not None:
                    write_junit(arguments.junit, outcomes, f"nav2 goals {namespace or '/'}")
        return 0 if all(outcome.reached for outcome in outcomes) else 1
    return 1  # Ctrl-C


def _read(text: str) -> list[NavigationGoal]:
    """Return the goals in the YAML file with this name, or the single goal that the text describes.

    Raises:
        UsageError: the text is neither the name of a file nor a goal.
        CheckError: the file has errors.
    """
    from graphengine.bringup.navigation.goal_list import NavigationGoal, read_goals

    path = Path(text)
    if path.suffix in (".yaml", ".yml") or path.is_file():
        if not path.is_file():
            raise UsageError(f"{text}: no such file")
        return read_goals(path)
    words = text.replace(",", " ").split()
    try:
        if len(words) not in (2, 3):
            raise argparse.ArgumentTypeError(f"expected two or three numbers, got {len(words)}")
        x, y, *yaw = words
        return [NavigationGoal(number(x), number(y), angle(yaw[0]) if yaw else 0.0)]
    except argparse.ArgumentTypeError as error:
        advice = "write a goal as 'X Y YAW', such as '1.5 -2 90deg', or name a YAML file"
        raise UsageError(f"{text!r}: {error}\n  {advice}") from None


def _action(live: Live, arguments: argparse.Namespace) -> str:
    """Wait for an action server of Nav2, in the given namespace if any, and return the full name of its action.

    Raises:
        TransportError: no server appears within `--wait` s, or there are several servers and no namespace is given.
    """
    from graphengine.bringup.navigation.navigator import ACTION

    given = arguments.namespace
    wanted = None if given is None else f"{absolute_namespace(given)}/{ACTION}"

    def found() -> list[str]:
        servers = _servers(live)
        return [wanted] if wanted in servers else [] if wanted is not None else servers

    live.graph()
    deadline, told = time.monotonic() + arguments.wait, False
    while not (there := found()) and time.monotonic() < deadline:
        if not told:
            told = True
            _say(f"waiting for the action {wanted or ACTION} of Nav2")
        time.sleep(POLL)
    if len(there) == 1:
        return there[0]
    names = [name.removesuffix(f"/{ACTION}") or "/" for name in there or _servers(live)]
    if there:
        advice = listing(names, "choose one with --namespace")
        raise TransportError(f"there are {len(there)} robots with Nav2\n{advice}")
    foreign = [text for name, text in live.transport.foreign_services.items() if f"/{ACTION}/" in f"{name}/"]
    hint = listing(names, "namespaces with Nav2") if names else "is Nav2 running in this domain?"
    raise TransportError(f"no action {wanted or ACTION}\n{foreign[0] if foreign else hint}\nsearched {live.where}")


def _servers(live: Live) -> list[str]:
    """Return the sorted names of the NavigateToPose actions whose feedback a peer publishes."""
    from graphengine.bringup.navigation.navigator import ACTION

    published = {end.topic for end in live.graph_now().endpoints if end.direction == "publish"}
    return sorted(topic.removesuffix(FEEDBACK) for topic in published if topic.endswith(f"/{ACTION}{FEEDBACK}"))


@contextlib.contextmanager
def _truth(run: str, namespace: str, clock: Callable[[], float] | None) -> Iterator[TruePoses | None]:
    """Yield the true poses of the robot, read from the run; if they are unknown, print the reason and yield None.

    Raises:
        ControlError: the run given by `--run` cannot be reached, or is not the publisher of /clock.
        UsageError: there are several runs, and `--run` is not given.
    """
    from graphengine.bringup.navigation.true_poses import TruePoses

    truth = None
    try:
        truth = TruePoses(run, namespace)
        if clock is not None and abs(clock() - truth.time) > SAME_TIME:
            times = f"{truth.time:.1f} s in the run, {clock():.1f} s on /clock"
            why = f"the times differ ({times}); choose a run with --run"
            raise ControlError(f"{truth.entry} does not publish the /clock of this network: {why}")
    except ControlError as error:
        if truth is not None:
            truth.close()
        if run:
            raise
        _say(f"true poses are unknown: {error}")
        yield None
        return
    with contextlib.closing(truth):
        yield truth


def _heard_clock(live: Live) -> Callable[[], float] | None:
    """Return a function that returns the simulation time on /clock, s; None if no message arrives within `CLOCK_PATIENCE`."""
    from graphengine.ros.cli_subscription import SimulationClock

    clock = SimulationClock(live.transport)
    return (lambda: clock() * 1e-9) if clock.wait(CLOCK_PATIENCE) else None


def _other_clock(truth: TruePoses | None) -> Callable[[], float]:
    """Return a function that returns the simulation time of the run, s, or without a run the wall time, s."""
    if truth is not None:
        return lambda: truth.time
    _say("no messages on /clock: times are wall times")
    return time.time


def _drive(go: Callable[..., Outcome], goal: NavigationGoal, place: str) -> Outcome:
    """Send a goal, wait until it ends, print its outcome and return it; on a terminal, also show the progress.

    Args:
        go: sends its first argument, a goal; calls its second argument with each progress; and returns the outcome.
        goal: the goal to send.
        place: place of the goal among all goals, such as `2/5`.
    """
    line = terminal.start_live_line() if terminal.can_overwrite() else None

    def watch(progress: Progress) -> None:
        if line is not None:
            terminal.overwrite(line, _parts(progress, place), "   ")

    try:
        outcome = go(goal, watch)
    finally:
        if line is not None:
            line.stop()
    reason = f": {outcome.reason}" if outcome.reason else ""
    spent = f" in {outcome.time:.1f} s" if outcome.time is not None else ""
    _say(f"goal {place} ({goal.label}) {outcome.result}{spent}{reason}")
    return outcome


def _parts(progress: Progress, place: str) -> Sequence[tuple[str, str]]:
    """Return the texts of the progress line, each with its style for rich."""
    parts = [(f"goal {place} ({clean(progress.goal.label)})", "bold"), (f"{progress.time:.1f} s", "")]
    if progress.distance is not None:
        parts.append((f"{progress.distance:.2f} m left", ""))
    if progress.remaining_time:
        parts.append((f"about {progress.remaining_time:.0f} s", "dim"))
    if progress.recoveries:
        parts.append((f"recoveries: {progress.recoveries}", "yellow"))
    return parts


def _say(text: str) -> None:
    """Print a message on standard error; standard output is for the results."""
    print(clean(text), file=sys.stderr, flush=True)
