"""A graph for each robot of a fleet, made node by node."""

from __future__ import annotations

from dataclasses import dataclass, field

from isaacsim import SimulationApp

simulation_app = SimulationApp({"headless": True})

import omni.graph.core as og  # noqa: E402
from isaacsim.core.api import World  # noqa: E402
from isaacsim.core.utils.extensions import enable_extension  # noqa: E402

enable_extension("isaacsim.ros2.bridge")
simulation_app.update()


@dataclass(frozen=True)
class Robot:
    name: str
    prim: str = "/World/{name}"
    radius: float = 0.0325
    topics: dict[str, str] = field(default_factory=lambda: {"cmd": "cmd_vel"})


def drive(robot: Robot, *, evaluator: str = "execution", namespace: str | None = None) -> og.Graph:
    path = f"/World/Graphs/{robot.name}"
    graph = og.Controller.create_graph({"graph_path": path, "evaluator_name": evaluator})
    tick = og.Controller.create_node(("tick", graph), "omni.graph.action.OnPlaybackTick")
    twist = og.Controller.create_node(f"{path}/twist", "isaacsim.ros2.bridge.ROS2SubscribeTwist")
    linear, angular = (og.Controller.create_node((n, graph), "omni.graph.nodes.BreakVector3") for n in ("lin", "ang"))
    diff = graph.create_node(f"{path}/diff", "isaacsim.robot.wheeled_robots.DifferentialController", True)
    wheels = og.Controller.create_node(f"{path}/wheels", "isaacsim.core.nodes.IsaacArticulationController")
    og.Controller.connect(og.Controller.attribute("outputs:tick", tick), og.Controller.attribute("inputs:execIn", twist))
    og.Controller.connect(("outputs:tick", tick), ("inputs:execIn", wheels))
    og.Controller.connect(twist.get_attribute("outputs:execOut"), diff.get_attribute("inputs:execIn"))
    for source, node, part in (("linearVelocity", linear, "x"), ("angularVelocity", angular, "z")):
        og.Controller.connect(twist.get_attribute(f"outputs:{source}"), node.get_attribute("inputs:tuple"))
        og.Controller.connect(node.get_attribute(f"outputs:{part}"), diff.get_attribute(f"inputs:{source}"))
    diff.get_attribute("outputs:velocityCommand").connect(wheels.get_attribute("inputs:velocityCommand"), True)
    og.Controller.attribute("inputs:wheelRadius", diff).set(robot.radius)
    og.AttributeValueHelper(diff.get_attribute("inputs:wheelDistance")).set(0.1125)
    og.Controller(og.Controller.attribute("inputs:topicName", twist)).set(value=robot.topics["cmd"])
    og.Controller.set(attribute=wheels.get_attribute("inputs:robotPath"), value=robot.prim.format(name=robot.name))
    if namespace:
        og.DataView.set(attribute=twist.get_attribute("inputs:nodeNamespace"), value=namespace)
    return graph


ROBOTS = [Robot("jetbot"), Robot("carter", radius=0.14, topics={"cmd": "go"})]
world = World(stage_units_in_meters=1.0)
graphs = {robot.name: drive(robot, namespace=f"fleet{n}" if n else None) for n, robot in enumerate(ROBOTS)}
world.reset()
while simulation_app.is_running():
    world.step(render=True)
simulation_app.close()
