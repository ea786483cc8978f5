"""Checks QoS profiles and stamps of the nodes that send messages."""

from __future__ import annotations

from dataclasses import replace

from graphengine.compiler.graph import Graph, Instance
from graphengine.compiler.lint_registry import LintContext
from graphengine.format.errors import TopicError
from graphengine.messages.qos import parse_qos

_UNUSED_PROFILE = (("static_publisher", True), ("enabled", False))
"""Fields of inputs, each with the value for which a node does not use its QoS profile."""
_STAMPS = ("time_stamp", "sensor_time", "message__header__stamp__sec", "message__header__stamp__nanosec")
"""Fields of inputs that set the stamp of a message; the last two belong to a ROS2Publisher."""
_TIMES = ("sensor_time", "time_stamp", "simulation_time")
"""Fields of outputs that are stamps, the most exact first."""


def check_qos(context: LintContext) -> None:
    """Report unreadable QoS profiles, also of nodes that could not be set up.

    A latched or disabled node runs without using its profile, and so gets a warning instead of an error.
    """
    for graph in context.graphs:
        wired = graph.wired_ports
        for instance in graph.instances:
            text = instance.literals.get("qos_profile")
            if not text or (instance.id, "qosProfile") in wired:
                continue
            try:
                parse_qos(text)
            except TopicError as error:
                idle = any(instance.literals.get(name) is value for name, value in _UNUSED_PROFILE)
                context.findings.put(replace(instance.refusal(error), code="W216" if idle else error.code))


def check_stamps(context: LintContext) -> None:
    """Add a warning for each publisher that stamps all messages 0, because no input for the stamp is wired or set."""
    for graph in context.graphs:
        given, running = graph.wired_ports | graph.declared_inputs, set(graph.plan.order)
        for instance in graph.instances:
            ports = [port for name in _STAMPS if (port := instance.cls.fields.get(name)) and port.side == "inputs"]
            known = instance.literals.keys() | instance.refused
            if (
                not ports
                or "node_namespace" not in instance.cls.fields  # no node with an endpoint
                or instance.index not in running
                or any(port.field in known or (instance.id, port.name) in given for port in ports)
                or instance.literals.get("static_publisher")  # tf2 ignores the stamps of static transforms
            ):
                continue
            message = f"{instance.id} stamps all its messages with the time 0: {ports[0].name} is not wired"
            why = "tf2 and Nav2 drop messages that are too old"
            remedy = _stamp_remedy(graph, instance, ports[0].name)
            context.findings.add("W213", message, instance.span, why, remedy, related=instance.entry.via)


def _stamp_remedy(graph: Graph, instance: Instance, port: str) -> str:
    """Return the advice to wire the time output of a node that feeds the publisher, else the simulation time."""
    near = {wire.source for wire in graph.data_wires if wire.target == instance.index}
    sources = [
        (other.index not in near, _TIMES.index(name), f"{other.id}.{other.cls.fields[name].name}")
        for other in graph.instances
        for name in _TIMES
        if name in other.cls.fields and other.cls.fields[name].side == "outputs"
        if other.index in near or name == "simulation_time"
    ]
    time = min(sources)[2] if sources else "ReadSimTime.simulationTime"
    new = [] if sources else ["ReadSimTime: IsaacReadSimulationTime"]
    wires = [f"{time} -> {instance.id}.{port}"]
    if ":" in port:
        new.append("SplitTime: IsaacTimeSplitter")
        ends = (("seconds", port), ("nanoseconds", port.replace("sec", "nanosec")))
        wires = [f"{time} -> SplitTime.time", *(f"SplitTime.{out} -> {instance.id}.{end}" for out, end in ends)]
    nodes = " and ".join(f"`{node}`" for node in new)
    return f"{f'add {nodes} to the nodes, and ' if new else ''}wire {', '.join(wires)}"
