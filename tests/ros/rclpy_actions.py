"""A program of ROS 2 for the tests: an action server or a client of rclpy, which prints what it sees as JSON lines.

Its arguments are the part that it plays, and the package that has the action Fibonacci.
"""

from __future__ import annotations

import contextlib
import importlib
import json
import sys
import threading
import time
from typing import Any

import rclpy
from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node

Fibonacci: Any = importlib.import_module(f"{sys.argv[2]}.action").Fibonacci


def say(**what: Any) -> None:
    sys.stdout.write(f"{json.dumps(what)}\n")
    sys.stdout.flush()


def serve(node: Node) -> None:
    """Reject orders below 0, abort at 0, pursue 1000 until cancelled, and compute the others."""

    def execute(goal: Any) -> Any:
        feedback, result = Fibonacci.Feedback(sequence=[0, 1]), Fibonacci.Result()
        for _ in range(goal.request.order):
            feedback.sequence.append(feedback.sequence[-1] + feedback.sequence[-2])
            goal.publish_feedback(feedback)
            if goal.is_cancel_requested:
                goal.canceled()
                return Fibonacci.Result(sequence=[9])
            time.sleep(0.02)
        result.sequence = feedback.sequence
        goal.succeed() if goal.request.order else goal.abort()
        return result

    ActionServer(
        node,
        Fibonacci,
        "fibonacci",
        execute,
        goal_callback=lambda goal: GoalResponse.REJECT if goal.order < 0 else GoalResponse.ACCEPT,
        cancel_callback=lambda goal: CancelResponse.ACCEPT,
    )
    sys.stdin.read()


def call(node: Node) -> None:
    """Send the goals whose orders come by the input: a line with `cancel` cancels the latest one."""
    client = ActionClient(node, Fibonacci, "fibonacci")
    assert client.wait_for_server(60.0)
    latest: list[Any] = []

    def answered(order: int, future: Any) -> None:
        handle = future.result()
        say(order=order, accepted=handle.accepted)
        if handle.accepted:
            latest.append(handle)
            handle.get_result_async().add_done_callback(lambda result: ended(order, result.result()))

    def ended(order: int, outcome: Any) -> None:
        say(order=order, status=outcome.status, sequence=list(outcome.result.sequence))

    def hear(order: int, message: Any) -> None:
        say(order=order, feedback=list(message.feedback.sequence))

    for line in sys.stdin:
        if line.strip() == "cancel":
            answer = latest[-1].cancel_goal_async()
            answer.add_done_callback(lambda done: say(cancelling=len(done.result().goals_canceling)))
            continue
        order = int(line)
        sent = client.send_goal_async(Fibonacci.Goal(order=order), lambda message, order=order: hear(order, message))
        sent.add_done_callback(lambda future, order=order: answered(order, future))


if __name__ == "__main__":
    rclpy.init()
    here = Node(f"rclpy_{sys.argv[1]}")
    # A server needs threads, to be cancelled while it executes; with them, a client loses answers that come at once.
    executor = MultiThreadedExecutor(num_threads=4) if sys.argv[1] == "serve" else SingleThreadedExecutor()
    executor.add_node(here)

    def spin() -> None:
        with contextlib.suppress(ExternalShutdownException):
            executor.spin()

    spinning = threading.Thread(target=spin)
    spinning.start()
    {"serve": serve, "call": call}[sys.argv[1]](here)
    rclpy.shutdown()
    spinning.join()
