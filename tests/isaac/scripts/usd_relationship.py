import omni.graph.core as og
import omni.usd
from isaacsim.core.utils.prims import set_targets
from isaacsim.core.utils.stage import get_current_stage
from pxr import Sdf

graph, nodes, _, _ = og.Controller.edit(
    {"graph_path": "/World/relationships", "evaluator_name": "execution"},
    {
        og.Controller.Keys.CREATE_NODES: [
            ("Tick", "omni.graph.action.OnPlaybackTick"),
            ("Odom", "isaacsim.core.nodes.IsaacComputeOdometry"),
            ("Tf", "isaacsim.ros2.bridge.ROS2PublishTransformTree"),
            ("Joints", "isaacsim.ros2.bridge.ROS2PublishJointState"),
        ],
        og.Controller.Keys.CONNECT: [
            ("Tick.outputs:tick", f"{node}.inputs:execIn") for node in ("Odom", "Tf", "Joints")
        ],
    },
)
stage = omni.usd.get_context().get_stage()
odom = stage.GetPrimAtPath("/World/relationships/Odom")
odom.GetRelationship("inputs:chassisPrim").SetTargets([Sdf.Path("/World/robot/base")])
set_targets(
    prim=get_current_stage().GetPrimAtPath("/World/relationships/Tf"),
    attribute="inputs:targetPrims",
    target_prim_paths=["/World/robot"],
)
joints = stage.GetPrimAtPath(nodes[3].get_prim_path())
joints.GetRelationship("inputs:targetPrim").AddTarget("/World/robot")
joints.GetAttribute("inputs:topicName").Set("robot/joint_states")
joints.CreateAttribute("ui:nodegraph:node:pos", Sdf.ValueTypeNames.Float2).Set((420.0, -35.5))
