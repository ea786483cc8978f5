"""Graphs that offer and call the service /light of std_srvs/SetBool, and its messages."""

from __future__ import annotations

from graphengine.messages import messages

SET_BOOL = "std_srvs/srv/SetBool"
ASK, ANSWER = messages.message_class(f"{SET_BOOL}_Request"), messages.message_class(f"{SET_BOOL}_Response")


def extended(graph: str, nodes: str, *wires: str) -> str:
    """A graph with more nodes, as lines below `nodes:`, and more wires."""
    return graph.replace("connections:\n", nodes + "connections:\n" + "".join(f"  - {wire}\n" for wire in wires))


EMPTY = "nodes:\n  Tick: OnPlaybackTick\nconnections:\n"
SERVER = extended(
    EMPTY,
    """  Server:
    type: ROS2ServiceServerRequest
    inputs: {serviceName: light, messagePackage: std_srvs, messageName: SetBool}
  Answer:
    type: ROS2ServiceServerResponse
    inputs: {messagePackage: std_srvs, messageName: SetBool, "Response:message": done}
""",
    "Tick.tick -> Server.execIn",
    "Server.onReceived -> Answer.onReceived",
    "Server.serverHandle -> Answer.serverHandle",
    "Server.Request:data -> Answer.Response:success",
)
"""Answers each request with `done`, and success where the request's data is true."""
_CALLING = (
    """  Client:
    type: ROS2ServiceClient
    inputs: {serviceName: light, messagePackage: std_srvs, messageName: SetBool, "Request:data": true}
  Say: {type: ROS2Publisher, inputs: {topicName: said, messagePackage: std_msgs, messageName: String}}
""",
    "Tick.tick -> Client.execIn",
    "Client.execOut -> Say.execIn",
    "Client.Response:message -> Say.data",
)
CLIENT = extended(EMPTY, *_CALLING)
"""Calls in each tick, and says each answer's message on /said."""
BOTH = extended(SERVER, *_CALLING)
