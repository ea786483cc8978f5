import carb
import omni.graph.core as og
import omni.usd

ROBOT = "/World/husky"
prim = omni.usd.get_context().get_stage().GetPrimAtPath(ROBOT)
if not prim or not prim.IsValid():
    carb.log_error(f"{ROBOT} is not on the stage")
    raise RuntimeError("load the robot first")
og.Controller.edit(
    {"graph_path": str(prim.GetPath()) + "/joints", "evaluator_name": "execution"},
    {
        og.Controller.Keys.CREATE_NODES: [
            ("Tick", "omni.graph.action.OnPlaybackTick"),
            ("Joints", "isaacsim.ros2.bridge.ROS2PublishJointState"),
        ],
        og.Controller.Keys.CONNECT: [("Tick.outputs:tick", "Joints.inputs:execIn")],
        og.Controller.Keys.SET_VALUES: [("Joints.inputs:targetPrim", prim.GetPath())],
    },
)
