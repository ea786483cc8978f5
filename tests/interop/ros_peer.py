"""A ROS 2 node of the interop matrix, which uses rclpy and nothing of this project's: each line of input is a command in JSON.

Each command is answered by one line of JSON. The node ends when its input ends.
"""

from __future__ import annotations

import contextlib
import json
import sys
import threading
import time
from array import array
from typing import Any

import rclpy
from example_interfaces.action import Fibonacci
from geometry_msgs.msg import TransformStamped
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rclpy.action import ActionClient, ActionServer, CancelResponse
from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import DurabilityPolicy, HistoryPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy
from rclpy.time import Time
from rosidl_runtime_py.utilities import get_message
from std_srvs.srv import SetBool
from tf2_ros import Buffer, StaticTransformBroadcaster, TransformBroadcaster, TransformListener

from tests.interop.samples import GREETING, TYPES, Tally, fill, paced

PATIENCE = 20.0


def profile(depth: int = 10, latched: bool = False, reliable: bool = True, deadline: float = 0.0) -> QoSProfile:
    made = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=depth, liveliness=LivelinessPolicy.AUTOMATIC)
    made.reliability = ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT
    made.durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
    if deadline:
        made.deadline = Duration(seconds=deadline)
    return made


def seconds_until(condition: Any, patience: float = PATIENCE) -> float | None:
    """Return the seconds until something holds; None if it does not in time."""
    begun = time.monotonic()
    while not condition():
        if time.monotonic() - begun > patience:
            return None
        time.sleep(0.002)
    return time.monotonic() - begun


class Peer:
    """Carries out the commands: each public method is one."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._tallies: dict[str, Tally] = {}
        self._readers: dict[str, Any] = {}
        self._writers: dict[str, Any] = {}
        self._sent: dict[str, int] = {}
        self._events: list[str] = []
        self._kept: list[Any] = []

    def listen(self, topic: str, kind: str, size: int = 0, **qos: Any) -> None:
        tally = self._tallies[topic] = Tally(kind, size)
        callbacks = SubscriptionEventCallbacks(
            incompatible_qos=lambda event: self._events.append("incompatible"),
            deadline=lambda event: self._events.append("deadline"),
        )
        kinds = get_message(TYPES[kind]), topic, tally.add, profile(**qos)
        self._readers[topic] = self._node.create_subscription(*kinds, event_callbacks=callbacks)

    def heard(self, topic: str) -> dict[str, Any]:
        return self._tallies[topic].report()

    def talk(self, topic: str, kind: str, **qos: Any) -> None:
        callbacks = PublisherEventCallbacks(incompatible_qos=lambda event: self._events.append("incompatible"))
        self._writers[topic] = self._node.create_publisher(
            get_message(TYPES[kind]), topic, profile(**qos), event_callbacks=callbacks
        )

    def send(self, topic: str, kind: str, count: int, rate: float, size: int = 0, first: int = 0) -> dict[str, Any]:
        data, doubles = array("B", bytes([7]) * size), lambda values: array("d", values)

        def one(number: int) -> None:
            message = fill(get_message(TYPES[kind])(), kind, number, doubles, lambda name: get_message(name)(), data)
            self._writers[topic].publish(message)
            self._sent[topic] = number

        return {"seconds": paced(count, rate, one, first)}

    def sent(self, topic: str) -> dict[str, Any]:
        """Return the number of the last message that was sent on a topic."""
        return {"last": self._sent.get(topic, GREETING)}

    def stream(self, topic: str, kind: str, count: int, rate: float) -> None:
        """Send in the background."""
        threading.Thread(target=self.send, args=(topic, kind, count, rate), daemon=True).start()

    def matched(self, topic: str) -> dict[str, Any]:
        ends = self._writers.get(topic), self._readers.get(topic)
        readers = ends[0].get_subscription_count() if ends[0] else 0
        return {"matched": readers + (ends[1].get_publisher_count() if ends[1] else 0)}

    def events(self) -> dict[str, Any]:
        return {"events": list(self._events)}

    def serve(self, service: str) -> None:
        def answer(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
            response.success, response.message = request.data, "Grüße"
            return response

        self._kept.append(self._node.create_service(SetBool, service, answer))

    def call(self, service: str, count: int) -> dict[str, Any]:
        client = self._node.create_client(SetBool, service)
        found = seconds_until(client.service_is_ready)
        if found is None:
            return {"answered": 0}
        times, right = list[float](), 0
        for number in range(count):
            begun, future = time.monotonic(), client.call_async(SetBool.Request(data=number % 2 == 0))
            if seconds_until(future.done) is None:
                break
            times.append(1e3 * (time.monotonic() - begun))
            right += future.result().message == "Grüße" and future.result().success == (number % 2 == 0)
        return {"found": found, "answered": right, "times": times}

    def offer(self, action: str) -> None:
        def execute(goal: Any) -> Any:
            feedback = Fibonacci.Feedback(sequence=[0, 1])
            for _ in range(goal.request.order):
                feedback.sequence.append(feedback.sequence[-1] + feedback.sequence[-2])
                goal.publish_feedback(feedback)
                if goal.is_cancel_requested:
                    goal.canceled()
                    return Fibonacci.Result(sequence=[9])
                time.sleep(0.02)
            goal.succeed()
            return Fibonacci.Result(sequence=feedback.sequence)

        accept = {"cancel_callback": lambda goal: CancelResponse.ACCEPT}
        self._kept.append(ActionServer(self._node, Fibonacci, action, execute, **accept))

    def pursue(self, action: str, order: int) -> dict[str, Any]:
        """Send a goal to its end, then another that is cancelled; `answered` is false if no first goal is answered."""
        client, feedback = ActionClient(self._node, Fibonacci, action), list[Any]()
        found, begun = seconds_until(client.server_is_ready), time.monotonic()
        if found is None:
            return {"answered": False}
        ends, lost = list[tuple[float, Any]](), 0
        for cancels in (False, True):
            sent = client.send_goal_async(Fibonacci.Goal(order=order), feedback.append)
            while seconds_until(sent.done, 5.0) is None:
                lost += 1  # a first goal may be sent before the server knows of the client
                if lost == 4:
                    return {"answered": False}
                begun = time.monotonic()
                sent = client.send_goal_async(Fibonacci.Goal(order=order), feedback.append)
            handle = sent.result()
            if cancels:
                seconds_until(handle.cancel_goal_async().done)
            ended = handle.get_result_async()
            seconds_until(ended.done)
            ends.append((time.monotonic() - begun, ended.result()))
        (lasted, first), (_, second) = ends
        outcome = {"status": [first.status, second.status], "sequence": list(first.result.sequence)}
        return {**outcome, "answered": True, "found": found, "lost": lost, "feedback": len(feedback), "seconds": lasted}

    def parameters(self, node: str, name: str, value: float) -> dict[str, Any]:
        """Use all six parameter services of a node, with one parameter of type double."""
        client = AsyncParameterClient(self._node, node)
        found, lost = seconds_until(client.services_are_ready), 0
        while found is None or seconds_until(client.list_parameters([], 0).done, 5.0) is None:
            lost += 1  # a first call may be sent before the server knows of the client
            if found is None or lost == 4:
                return {"answered": False}

        def result(future: Any) -> Any:
            seconds_until(future.done)
            return future.result()

        def parameter(**fields: Any) -> Parameter:
            return Parameter(name=name, value=ParameterValue(**fields))

        double = parameter(type=ParameterType.PARAMETER_DOUBLE, double_value=value)
        wrong = result(client.set_parameters([parameter(type=ParameterType.PARAMETER_STRING, string_value="fast")]))
        atomically = result(client.set_parameters_atomically([double])).result
        return {
            "answered": True,
            "found": found,
            "lost": lost,
            "listed": name in result(client.list_parameters([], 0)).result.names,
            "described": bool(result(client.describe_parameters([name])).descriptors[0].description),
            "type": list(result(client.get_parameter_types([name])).types),
            "set": result(client.set_parameters([double])).results[0].successful and atomically.successful,
            "refused": "" if wrong.results[0].successful else wrong.results[0].reason,
            "value": result(client.get_parameters([name])).values[0].double_value,
        }

    def broadcast(self, count: int, rate: float) -> None:
        """Broadcast map -> odom once and odom -> base_link at a rate, in the background."""
        static, moving = StaticTransformBroadcaster(self._node), TransformBroadcaster(self._node)
        self._kept += [static, moving]

        def transform(parent: str, child: str, number: int) -> TransformStamped:
            made = TransformStamped(child_frame_id=child)
            made.header.frame_id, made.header.stamp = parent, Time(nanoseconds=10_000_000 * number).to_msg()
            made.transform.translation.x = float(number)
            return made

        def send() -> None:
            static.sendTransform(transform("map", "odom", 1))
            paced(count, rate, lambda number: moving.sendTransform(transform("odom", "base_link", number)))

        threading.Thread(target=send, daemon=True).start()

    def look_up(self, target: str, source: str, count: int) -> dict[str, Any]:
        """Wait until a chain of transforms has the wanted time, 10 ms times `count`; return its x."""
        buffer = Buffer()
        self._kept.append(TransformListener(buffer, self._node))
        begun, wanted = time.monotonic(), Time(nanoseconds=10_000_000 * count)
        found = seconds_until(lambda: buffer.can_transform(target, source, Time()))
        complete = seconds_until(lambda: buffer.can_transform(target, source, wanted))
        if found is None or complete is None:
            return {"found": found, "x": None}
        x = buffer.lookup_transform(target, source, wanted).transform.translation.x
        return {"found": found, "x": x, "seconds": time.monotonic() - begun}


def main() -> None:
    rclpy.init()
    node = Node("interop_peer")
    # A server needs threads, to be cancelled while it executes; with them, a client loses answers that come at once.
    executor = MultiThreadedExecutor(4) if "--threads" in sys.argv else SingleThreadedExecutor()
    executor.add_node(node)
    peer = Peer(node)

    def spin() -> None:
        with contextlib.suppress(ExternalShutdownException):
            executor.spin()

    spinning = threading.Thread(target=spin)
    spinning.start()
    sys.stdout.write("{}\n")
    sys.stdout.flush()
    for line in sys.stdin:
        command = json.loads(line)
        answer = getattr(peer, command.pop("do"))(**command)
        sys.stdout.write(f"{json.dumps(answer or {})}\n")
        sys.stdout.flush()
    rclpy.shutdown()
    spinning.join()


if __name__ == "__main__":
    main()
