import omni.graph.core as og
import omni.usd

PATH = "/World/clock"
stage = omni.usd.get_context().get_stage()
if stage.GetPrimAtPath(PATH):
    stage.RemovePrim(PATH)
k = og.Controller.Keys
og.Controller.edit(
    {"graph_path": PATH, "evaluator_name": "execution"},
    {
        k.CREATE_NODES: [
            ("OnPlaybackTick", "omni.graph.action.OnPlaybackTick"),
            ("Context", "isaacsim.ros2.bridge.ROS2Context"),
            ("ReadSimTime", "isaacsim.core.nodes.IsaacReadSimulationTime"),
            ("PublishClock", "isaacsim.ros2.bridge.ROS2PublishClock"),
        ],
        k.CONNECT: [
            ("OnPlaybackTick.outputs:tick", "PublishClock.inputs:execIn"),
            ("ReadSimTime.outputs:simulationTime", "PublishClock.inputs:timeStamp"),
            ("Context.outputs:context", "PublishClock.inputs:context"),
        ],
    },
)
