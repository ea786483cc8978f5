"""Graphs for tests of services: a server of /light, and a client that calls it."""

from __future__ import annotations

SET_BOOL = "std_srvs/srv/SetBool"
LIGHT = """graph: light
nodes:
  Tick: OnPlaybackTick
  Server:
    type: ROS2ServiceServerRequest
    inputs: {serviceName: light, messagePackage: std_srvs, messageName: SetBool}
  Answer:
    type: ROS2ServiceServerResponse
    inputs: {messagePackage: std_srvs, messageName: SetBool, "Response:message": done}
connections:
  - Tick.tick -> Server.execIn
  - Server.onReceived -> Answer.onReceived
  - Server.serverHandle -> Answer.serverHandle
  - Server.Request:data -> Answer.Response:success
"""
CALLING = """graph: calling
nodes:
  Tick: OnPlaybackTick
  Client:
    type: ROS2ServiceClient
    inputs: {serviceName: light, messagePackage: std_srvs, messageName: SetBool, "Request:data": true}
  Say: {type: ROS2Publisher, inputs: {topicName: said, messagePackage: std_msgs, messageName: String}}
connections:
  - Tick.tick -> Client.execIn
  - Client.execOut -> Say.execIn
  - Client.Response:message -> Say.data
"""
