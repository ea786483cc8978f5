"""Sends goals to Nav2's action NavigateToPose and measures how the robot reaches these goals."""

from __future__ import annotations

import itertools
import math
import queue
import time
from collections.abc import Callable
from concurrent.futures import TimeoutError as NotYet
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any

from graphengine.bringup.navigation.goal_list import NavigationGoal
from graphengine.bringup.navigation.outcome import REACHED, RESET, Outcome, error_name
from graphengine.bringup.navigation.true_poses import MAP, PlanarPose, TruePoses
from graphengine.format.errors import GraphError
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.messages.goals import CANCELED, STATUS_NAMES, SUCCEEDED
from graphengine.ros.action_caller import ActionCaller, GoalCall
from graphengine.ros.transport import Transport

ACTION = "navigate_to_pose"
ACTION_TYPE = "nav2_msgs/action/NavigateToPose"
POLL = 0.1
"""Wall time between two checks of a goal, s."""
RETRY = 1.0
"""Wall time between two attempts to send a goal that Nav2 rejects, because it may still be inactive, s."""
LOST = 5.0
"""Wall time without an action server after which the navigator gives up, s; for the first goal, at least `activation`."""
ANSWER = 10.0
"""Maximum wall time to wait until the server accepts, rejects or cancels a goal, s."""
BACKWARD = 0.5
"""Simulation time by which the clock goes back at least in a reset of the run, s."""
STANDSTILL = 60.0
"""Wall time after which the navigator gives up if the simulation time stands still in a run that is not paused, s."""


@dataclass(frozen=True, slots=True)
class Progress:
    """The state of an active goal; times are simulation times in s, distances are in m."""

    goal: NavigationGoal
    time: float
    distance: float | None = None
    remaining_time: float | None = None
    recoveries: int = 0


@dataclass(slots=True)
class Track:
    """Feedback on a goal.

    Attributes:
        poses: a dict from simulation times, s, to Nav2's estimated poses of the robot.
        recoveries: number of recoveries.
        distance: remaining distance, m.
        remaining_time: estimated remaining time, s.
    """

    poses: dict[float, PlanarPose] = field(default_factory=dict)
    recoveries: int | None = None
    distance: float | None = None
    remaining_time: float | None = None

    def add(self, feedback: Any, now: float) -> None:
        """Add a feedback message; `now` is the simulation time of its arrival, s."""
        head = feedback.current_pose.header
        if head.frame_id:  # the first feedback of Nav2 can have no pose
            stamp = messages.seconds(head.stamp) or now
            self.poses[stamp] = PlanarPose.of(feedback.current_pose.pose)
        self.recoveries, self.distance = int(feedback.number_of_recoveries), float(feedback.distance_remaining)
        self.remaining_time = messages.seconds(feedback.estimated_time_remaining)

    @property
    def last(self) -> PlanarPose | None:
        """The newest estimated pose; None before the first feedback with a pose."""
        return self.poses[max(self.poses)] if self.poses else None

    @property
    def way(self) -> float | None:
        """Length of the path through the estimated poses, m; None without poses."""
        poses = [self.poses[stamp] for stamp in sorted(self.poses)]
        return sum((a.distance(b) for a, b in itertools.pairwise(poses)), 0.0) if poses else None


_WAS_RESET = "the run was reset"


class FailedError(Exception):
    """A goal was not reached. The arguments are the result, such as `timed out`, and the reason."""


class GivenUpError(FailedError):
    """Neither the current goal nor a later one can be reached, for example because the run has ended."""


class Navigator:
    """Sends goals of one robot to Nav2 and measures the outcomes.

    Args:
        transport: open transport; closing it also closes the endpoints of the navigator.
        action: full name of the action.
        clock: returns the simulation time, s.
        truth: true poses of the robot; None if they are unknown.
        definitions: definitions of the message types.
        patience: maximum simulation time for each goal, s.
        activation: maximum wall time to wait until Nav2 is discovered and active, s.
        say: prints a message for the user.
    """

    def __init__(
        self,
        transport: Transport,
        action: str,
        clock: Callable[[], float],
        truth: TruePoses | None = None,
        definitions: Definitions = DEFINITIONS,
        *,
        patience: float = 300.0,
        activation: float = 60.0,
        say: Callable[[str], None] = lambda text: None,
    ) -> None:
        self.caller = ActionCaller(transport, action, ACTION_TYPE, definitions)
        self._action = action
        self._definitions = definitions
        self._clock = clock
        self._truth = truth
        self._patience = patience
        self._activation = activation
        self._say = say
        self._sent: dict[GoalCall, float] = {}
        """A dict from the calls for the present goal, except rejected ones, to the wall times at which they were sent."""
        self._accepted = False
        """Whether the server has accepted a goal and so shown that Nav2 is active."""
        self._seen = time.monotonic()
        self._moved = (clock(), time.monotonic())
        self.over = ""
        """Reason why no further goal can be reached; empty while goals can be reached."""

    def go(self, goal: NavigationGoal, watch: Callable[[Progress], None] = lambda progress: None) -> Outcome:
        """Send a goal, wait for its end and return the outcome.

        Args:
            goal: pose in the map.
            watch: receives the progress about ten times a second while the goal is active.

        Raises:
            KeyboardInterrupt: Ctrl-C; the goal is cancelled.
        """
        if self.over:
            return Outcome(goal, "not sent", self.over)
        self._seen, self._moved = time.monotonic(), (self._clock(), time.monotonic())
        arrived: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._sent.clear()
        track, begun = Track(), None
        try:
            call = self._send(goal, arrived.put, watch)
            begun = self._clock()
            result, reason = self._follow(goal, call, arrived, track, begun, watch)
        except FailedError as failed:
            self._cancel()
            result, reason = failed.args
            if isinstance(failed, GivenUpError):
                self.over = f"{result}: {reason}"
        except GraphError as error:  # such as an answer that cannot be decoded
            self._cancel()
            result, reason = "failed", str(error)
        except KeyboardInterrupt:
            self._cancel()
            raise
        if begun is not None and result != REACHED and self._clock() < begun - BACKWARD:
            result, reason = RESET, _WAS_RESET  # whatever Nav2 made of it
        outcome = Outcome(goal, result, reason)
        return outcome if begun is None or result == RESET else self._measured(outcome, track, begun)

    def _send(
        self, goal: NavigationGoal, feedback: Callable[[Any], object], watch: Callable[[Progress], None]
    ) -> GoalCall:
        """Send a goal until the server accepts it, again after each rejection; return the accepted call.

        Raises:
            FailedError: the server still rejects the goal after the maximum time, or does not answer two requests.
        """
        deadline, told = time.monotonic() + (RETRY * 3 if self._accepted else self._activation), False
        while True:
            watch(Progress(goal, 0.0))
            while not self.caller.ready:
                self._look()
                time.sleep(POLL)
            call = self.caller.send(self._message(goal), feedback)
            self._sent[call] = time.monotonic()
            if not self._answered(call):
                if len(self._sent) == 2:
                    text = f"{self._action} did not answer two requests within {ANSWER:g} s each"
                    raise FailedError("no answer", text)
                continue  # if only the answer was lost, the new goal replaces the first
            if call.accepted.result():
                self._accepted = True
                return call
            del self._sent[call]
            if time.monotonic() > deadline:
                advice = "check that Nav2 is active, and see its log"
                raise FailedError("rejected", f"Nav2 did not accept the goal; {advice}")
            if not told:
                told = True
                self._say(f"{self._action} rejects the goal: waiting until Nav2 is active")
            self._look()
            time.sleep(RETRY)

    def _answered(self, call: GoalCall) -> bool:
        """Wait until the server accepts or rejects a call, at most `ANSWER` s; return whether the server has answered."""
        while time.monotonic() - self._sent[call] <= ANSWER:
            with suppress(NotYet):
                call.accepted.exception(POLL)
                return True
            self._look()
        return False

    def _follow(
        self,
        goal: NavigationGoal,
        call: GoalCall,
        arrived: queue.SimpleQueue[Any],
        track: Track,
        begun: float,
        watch: Callable[[Progress], None],
    ) -> tuple[str, str]:
        """Wait for the end of an accepted goal; return the result and, if the goal was not reached, the reason.

        Raises:
            FailedError: the goal is not reached within the maximum simulation time.
        """
        while not call.result.done():
            with suppress(NotYet):
                call.result.exception(POLL)
            now = self._clock()
            while not arrived.empty():
                track.add(arrived.get(), now)
            watch(Progress(goal, now - begun, track.distance, track.remaining_time, track.recoveries or 0))
            if call.result.done():
                break
            self._look()
            if now - begun > self._patience:
                raise FailedError("timed out", f"not reached within {self._patience:g} s")
        response = call.result.result()
        if response.status == SUCCEEDED:
            return REACHED, ""
        if response.status == CANCELED:
            return "canceled", "by another client"
        named = (error_name(int(response.result.error_code)), str(response.result.error_msg))
        status = STATUS_NAMES[response.status] if response.status in range(len(STATUS_NAMES)) else "unknown"
        return status, ": ".join(filter(None, named)) or "Nav2 gives no reason; see the log of bt_navigator"

    def _look(self) -> None:
        """Check that the action server exists and that the simulation runs.

        Raises:
            FailedError: the run was reset.
            GivenUpError: the server is lost, the run has ended, or the simulation time does not progress.
        """
        wall, now = time.monotonic(), self._clock()
        if now < self._moved[0] - BACKWARD:
            self._moved = now, wall
            raise FailedError(RESET, _WAS_RESET)
        if self._truth is not None and self._truth.ended:
            raise GivenUpError("run ended", self._truth.ended)
        if self.caller.ready:
            self._seen = wall
        elif wall - self._seen > (limit := LOST if self._accepted else max(LOST, self._activation)):
            raise GivenUpError("server lost", f"{self._action} has had no server for {limit:g} s; did Nav2 end?")
        if now != self._moved[0] or (self._truth is not None and self._truth.paused):
            self._moved = now, wall
        elif wall - self._moved[1] > STANDSTILL:
            raise GivenUpError("time stands still", f"no progress on /clock for {STANDSTILL:g} s; did the run end?")

    def _cancel(self) -> None:
        """Cancel the present goal and wait until it has ended, at most `ANSWER` s for each answer."""
        for call, sent in self._sent.items():
            accepted = None
            with suppress(NotYet, GraphError):  # a cancel that overtakes its goal has no effect
                accepted = call.accepted.result(max(0.0, sent + ANSWER - time.monotonic()))
            if accepted is False or call.result.done() or not self.caller.ready:
                continue
            with suppress(NotYet, GraphError):
                self.caller.cancel(call.goal).result(ANSWER)
                if accepted:
                    call.result.exception(ANSWER)

    def _message(self, goal: NavigationGoal) -> Any:
        message = self._definitions.initial(f"{ACTION_TYPE}_Goal")
        message.pose.header = messages.header(self._clock(), MAP)
        PlanarPose(goal.x, goal.y, goal.yaw).put_into(message.pose.pose)
        return message

    def _measured(self, outcome: Outcome, track: Track, begun: float) -> Outcome:
        """Return a copy of an outcome with the measurements from the feedback and the true poses."""
        goal, end = PlanarPose(outcome.goal.x, outcome.goal.y, outcome.goal.yaw), self._clock()
        measured = replace(
            outcome,
            time=end - begun,
            path=track.way,
            error=track.last.distance(goal) if track.last is not None else None,
            recoveries=track.recoveries,
        )
        truth = self._truth
        if truth is None:
            return measured
        truth.wait_until(end)
        pairs = [(truth.at(stamp), believed) for stamp, believed in track.poses.items()]
        errors = [true.distance(believed) for true, believed in pairs if true is not None]
        true = truth.at(end) or truth.newest
        return replace(
            measured,
            path=truth.way(begun, end),
            true_error=true.distance(goal),
            true_turn=true.turn(goal),
            localization=(math.fsum(errors) / len(errors), max(errors)) if errors else None,
        )
