"""Graphs that offer and call the action /fibonacci of example_interfaces/Fibonacci."""

from __future__ import annotations

from graphengine.messages import messages
from tests.service_graph import EMPTY, extended

FIBONACCI = "example_interfaces/action/Fibonacci"
GOAL, RESULT = messages.message_class(f"{FIBONACCI}_Goal"), messages.message_class(f"{FIBONACCI}_Result")
FEEDBACK = messages.message_class(f"{FIBONACCI}_Feedback")
TYPE = "messagePackage: example_interfaces, messageName: Fibonacci"

SERVER = extended(
    EMPTY,
    f"""  Server:
    type: ROS2ActionServerGoal
    inputs: {{actionName: fibonacci, {TYPE}}}
  Feedback:
    type: ROS2ActionServerFeedback
    inputs: {{{TYPE}, "Feedback:sequence": [0, 1]}}
  Count: {{type: Countdown, inputs: {{duration: 3}}}}
  Result:
    type: ROS2ActionServerResult
    inputs: {{{TYPE}, "Result:sequence": [0, 1, 1]}}
""",
    "Tick.tick -> Server.execIn",
    "Tick.tick -> Feedback.execIn",
    "Server.onGoal -> Count.execIn",
    "Count.finished -> Result.execIn",
    "Server.serverHandle -> Feedback.serverHandle",
    "Server.serverHandle -> Result.serverHandle",
)
"""Sends feedback in each tick, and succeeds three ticks after a goal came."""
_SENDING = (
    f"""  Client:
    type: ROS2ActionClient
    inputs: {{actionName: fibonacci, {TYPE}, "Goal:order": 3}}
  Once: {{type: Once}}
""",
    "Tick.tick -> Once.execIn",
    "Once.once -> Client.execIn",
)
CLIENT = extended(EMPTY, *_SENDING)
"""Sends a goal in the first tick."""
BOTH = extended(SERVER, *_SENDING)
