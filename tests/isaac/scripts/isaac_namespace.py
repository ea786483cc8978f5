import omni.graph.core as og
import omni.usd
from pxr import Sdf, UsdGeom

stage = omni.usd.get_context().get_stage()
UsdGeom.Xform.Define(stage, "/World/dingo/base_link")
base = stage.GetPrimAtPath("/World/dingo/base_link")
base.CreateAttribute("isaac:namespace", Sdf.ValueTypeNames.String).Set("dingo_1")
wheel = stage.DefinePrim("/World/dingo/wheel", "Xform")
wheel.CreateAttribute("isaac:nameOverride", Sdf.ValueTypeNames.String).Set("left wheel")
og.Controller.edit(
    {"graph_path": "/World/dingo/base_link/cmd-vel.graph", "evaluator_name": "execution"},
    {
        "create_nodes": [("On Tick", "omni.graph.action.OnPlaybackTick"), ("1st", "isaacsim.ros2.bridge.ROS2SubscribeTwist")],
        "connect": [("On Tick.outputs:tick", "1st.inputs:execIn")],
        "set_values": [("1st.inputs:topicName", "$(cmd)/vel")],
    },
)
