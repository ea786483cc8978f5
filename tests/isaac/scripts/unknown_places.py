import omni.graph.core as og
from isaacsim.core.api.robots import Robot

robot = Robot("/World/robot", name="robot")
place = robot.prim_path + "/joints"
og.Controller.edit(
    {"graph_path": place, "evaluator_name": "execution"},
    {
        "create_nodes": [
            ("tick", "omni.graph.action.OnPlaybackTick"),
            ("states", "isaacsim.ros2.bridge.ROS2PublishJointState"),
        ],
        "connect": [("tick.outputs:tick", "states.inputs:execIn")],
        "set_values": [("states.inputs:targetPrim", robot.prim_path)],
    },
)
og.Controller.attribute(f"{place}/states.inputs:topicName").set("states")
gain = og.Controller.get(og.Controller.attribute(place + "/states.inputs:queueSize"))
og.Controller.set(og.Controller.attribute(place + "/states.inputs:queueSize"), 2 * gain)
