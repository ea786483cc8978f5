import omni.graph.core as og
import omni.isaac.core.utils.stage as stage_utils
import omni.kit.commands
import omni.usd
import rclpy
import torch
from omni.isaac.core import World
from omni.isaac.core.utils.nucleus import get_assets_root_path
from pxr import Gf, Usd, UsdGeom
from rclpy.node import Node


class Listener(Node):
    def __init__(self):
        super().__init__("listener")
        self.subscription = self.create_subscription(int, "chatter", self.heard, 10)

    def heard(self, message):
        print(message)


rclpy.init()
listener = Listener()
world = World()
world.scene.add_default_ground_plane()
stage_utils.add_reference_to_stage(get_assets_root_path() + "/robot.usd", "/World/robot")
success, result = omni.kit.commands.execute("CreatePrimCommand", prim_type="Xform")
low, high = omni.usd.get_context().compute_path_world_bounding_box("/World/robot")
for prim in Usd.PrimRange(omni.usd.get_context().get_stage().GetPseudoRoot()):
    print(prim)
with Usd.EditContext(None, None):
    scale = UsdGeom.GetStageMetersPerUnit(omni.usd.get_context().get_stage())
UsdGeom.Xformable(omni.usd.get_context().get_stage().GetPrimAtPath("/World")).AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
print(f"{world.current_time:.2f} s, {torch.tensor([1.0]).cuda()}")
graph, nodes, *_ = og.Controller.edit(
    {
        "graph_path": "/World/mixed",
        "evaluator_name": "execution",
        "fc_backing_type": og.GraphBackingType.GRAPH_BACKING_TYPE_FABRIC_SHARED,
    },
    {og.Controller.Keys.CREATE_NODES: [("Tick", "omni.graph.action.OnTick")]},
)
og.Controller.edit(graph, {og.Controller.Keys.SET_VALUES: [(("inputs:onlyPlayback", nodes[0]), False)]})
og.Controller.edit(
    graph,
    {
        og.Controller.Keys.CREATE_NODES: [("Counter", "omni.graph.action.Counter")],
        og.Controller.Keys.CONNECT: [(nodes[0].get_attribute("outputs:tick"), "Counter.inputs:execIn")],
    },
)
og.Controller.set(og.Controller.attribute("inputs:logicalLoad", ("Counter", graph)), world.get_physics_dt())
