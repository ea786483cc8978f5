from isaacsim import SimulationApp

simulation_app = SimulationApp({"headless": True})

import numpy as np
import omni.graph.core as og
import omni.timeline
from isaacsim.core.api import World

ROBOT = "/World/robot"
world = World(stage_units_in_meters=1.0)
keys = og.Controller.Keys
og.Controller.edit(
    {"graph_path": "/World/drive", "evaluator_name": "execution"},
    {
        keys.CREATE_NODES: [
            ("Tick", "omni.graph.action.OnPlaybackTick"),
            ("Impulse", "omni.graph.action.OnImpulseEvent"),
            ("Drive", "isaacsim.robot.wheeled_robots.DifferentialController"),
            ("Clock", "isaacsim.ros2.bridge.ROS2PublishClock"),
        ],
        keys.CONNECT: [
            ("Tick.outputs:tick", "Drive.inputs:execIn"),
            ("Impulse.outputs:execOut", "Clock.inputs:execIn"),
        ],
        keys.SET_VALUES: [
            ("Drive.inputs:wheelRadius", 0.1),
            ("Drive.inputs:wheelDistance", 0.5),
            ("Drive.inputs:linearVelocity", 0.0),
        ],
        keys.CREATE_VARIABLES: [("speed", "double")],
    },
)
graph = og.Controller.graph("/World/drive")
graph.find_variable("speed").set(graph, 0.25)


def build_states():
    og.Controller.edit(
        {"graph_path": "/World/states", "evaluator_name": "execution"},
        {
            keys.CREATE_NODES: [
                ("Tick", "omni.graph.action.OnPlaybackTick"),
                ("States", "isaacsim.ros2.bridge.ROS2PublishJointState"),
            ],
            keys.CONNECT: [("Tick.outputs:tick", "States.inputs:execIn")],
        },
    )
    og.Controller.set(og.Controller.attribute("/World/states/States.inputs:topicName"), "states")


def step():
    world.step(render=True)


omni.timeline.get_timeline_interface().play()
for _ in range(10):
    step()
og.Controller.set(og.Controller.attribute("/World/drive/Drive.inputs:maxLinearSpeed"), 1.5)

built = False
while simulation_app.is_running():
    step()
    if not world.is_playing():
        continue
    if not built:
        build_states()
        og.Controller.attribute("/World/states/States.inputs:targetPrim").set(ROBOT)
        built = True
    og.Controller.attribute("/World/drive/Drive.inputs:linearVelocity").set(np.sin(world.current_time))
    graph.find_variable("speed").set(graph, 1.0)
    og.Controller.set(og.Controller.attribute("/World/drive/Impulse.state:enableImpulse"), True)
og.Controller.set(og.Controller.attribute("/World/drive/Drive.inputs:wheelRadius"), 0.0)
simulation_app.close()
