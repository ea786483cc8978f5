"""A Nav2 of one action for tests: it answers goals as it is told, on a transport of its own."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Any

import pytest

from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.messages.goals import ABORTED, SUCCEEDED
from graphengine.ros.action_caller import ActionCaller
from graphengine.ros.transport import Transport
from tests.action_peer import ActionServerPeer

ACTION_TYPE = "nav2_msgs/action/NavigateToPose"
POSE = "geometry_msgs/msg/PoseWithCovarianceStamped"

Behaviour = Callable[["Nav2Peer", bytes], None]


def pose_stamped(x: float, y: float, seconds: float) -> dict[str, Any]:
    """A pose of the map in plain form, at a simulation time."""
    sec = int(seconds)
    stamp = {"sec": sec, "nanosec": int((seconds - sec) * 1e9)}
    return {"header": {"frame_id": "map", "stamp": stamp}, "pose": {"position": {"x": x, "y": y}}}


class Nav2Peer(ActionServerPeer):
    """Answers each goal in a thread, by one behaviour after another; the last one stays.

    Args:
        transport: transport of the action.
        namespace: namespace of the robot.
        behaviours: what becomes of each goal.
        now: simulation time, s.
    """

    def __init__(
        self,
        transport: Transport,
        namespace: str,
        behaviours: Sequence[Behaviour],
        now: Callable[[], float] = lambda: 0.0,
    ) -> None:
        self._to_do = list(behaviours)
        self.now = now
        super().__init__(transport, f"{namespace}/navigate_to_pose", ACTION_TYPE)
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def feedback(self, goal: bytes, x: float, y: float, left: float = 0.0, recoveries: int = 0) -> None:
        """Send feedback."""
        pose = pose_stamped(x, y, self.now())
        self.say(goal, current_pose=pose, distance_remaining=left, number_of_recoveries=recoveries)

    def wait(self, condition: Callable[[], object]) -> bool:
        """Wait for something that the client does; False if the test ends before."""
        while not condition():
            if self._over.wait(0.005):
                return False
        return True

    def _serve(self) -> None:
        answered: list[bytes] = []
        while self.wait(lambda: len(self.messages) > len(answered)):
            behave = self._to_do.pop(0) if len(self._to_do) > 1 else self._to_do[0]
            answered.append(self.goals[len(answered)])
            behave(self, answered[-1])

    def close(self) -> None:
        """End the thread."""
        self._over.set()
        self._thread.join()


HEARD = set[bytes]()
"""UUIDs of the goals whose feedback a client in this process has heard; see `watch_feedback`."""


def watch_feedback(patch: pytest.MonkeyPatch) -> None:
    """Let clients in this process note in `HEARD` which feedback they have heard; `reach` waits for that."""
    take = ActionCaller._hear

    def hear(caller: ActionCaller, data: bytes) -> None:
        take(caller, data)
        HEARD.add(data[4:20])  # after the header of CDR

    patch.setattr(ActionCaller, "_hear", hear)


def reach(peer: Nav2Peer, goal: bytes) -> None:
    """Accept the goal, drive there in one step, and succeed."""
    peer.answer_goal()
    if peer.wait(lambda: goal in peer.asked):
        there = peer.messages[peer.goals.index(goal)].pose.pose.position
        peer.feedback(goal, there.x + 0.03, there.y - 0.04, left=0.05, recoveries=2)
        if peer.wait(lambda: goal in HEARD):
            peer.answer_result(SUCCEEDED)


def abort(peer: Nav2Peer, goal: bytes) -> None:
    """Accept the goal and fail to plan."""
    peer.answer_goal()
    if peer.wait(lambda: goal in peer.asked):
        peer.answer_result(ABORTED, error_code=208, error_msg="no way")


def reject(peer: Nav2Peer, goal: bytes) -> None:
    """Reject the goal, as before activation."""
    peer.answer_goal(accepted=False)


def dawdle(peer: Nav2Peer, goal: bytes) -> None:
    """Accept the goal and go nowhere."""
    peer.answer_goal()
    peer.wait(lambda: goal in peer.asked)
    peer.feedback(goal, 0.0, 0.0, left=7.5)


def dawdle_until_canceled(peer: Nav2Peer, goal: bytes) -> None:
    """Accept the goal, and end it only when it is canceled."""
    dawdle(peer, goal)
    if peer.wait(lambda: goal in peer.cancelled):
        peer.answer_cancel()
        peer.answer_result(5)


class Localization:
    """Takes initial poses and reports them on `amcl_pose`, as AMCL does.

    Args:
        transport: transport of the topics.
        namespace: namespace of the robot.
    """

    def __init__(self, transport: Transport, namespace: str) -> None:
        self.taken: list[Any] = []
        self._writer = transport.writer(f"{namespace}/amcl_pose", POSE, QoS(durability="transientLocal", depth=1))
        transport.reader(f"{namespace}/initialpose", POSE, QoS(), self._take)

    def _take(self, data: bytes) -> None:
        self.taken.append(messages.decode(data, POSE))
        self._writer.write(data)
