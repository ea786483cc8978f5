import sys

from isaacsim import SimulationApp

simulation_app = SimulationApp({"renderer": "RaytracedLighting", "headless": True})

import carb
import omni.graph.core as og
import usdrt.Sdf
from isaacsim.core.api import World
from isaacsim.core.utils import extensions, prims, rotations, stage, viewports
from isaacsim.storage.native import get_assets_root_path
from pxr import Gf

extensions.enable_extension("isaacsim.ros2.bridge")
simulation_app.update()
world = World(stage_units_in_meters=1.0)
assets_root_path = get_assets_root_path()
if assets_root_path is False:
    carb.log_error("Could not find Isaac Sim assets folder")
    simulation_app.close()
    sys.exit()
viewports.set_camera_view(eye=[1.2, 1.2, 0.8], target=[0, 0, 0.5])
stage.add_reference_to_stage(f"{assets_root_path}/Isaac/Environments/Simple_Room/simple_room.usd", "/background")
prims.create_prim(
    "/World/franka",
    "Xform",
    position=[0, -0.64, 0],
    orientation=rotations.gf_rotation_to_np_array(Gf.Rotation(Gf.Vec3d(0, 0, 1), 90)),
)
simulation_app.update()
try:
    og.Controller.edit(
        {"graph_path": "/ActionGraph", "evaluator_name": "execution"},
        {
            og.Controller.Keys.CREATE_NODES: [
                ("OnImpulseEvent", "omni.graph.action.OnImpulseEvent"),
                ("ReadSimTime", "isaacsim.core.nodes.IsaacReadSimulationTime"),
                ("PublishJointState", "isaacsim.ros2.bridge.ROS2PublishJointState"),
                ("SubscribeJointState", "isaacsim.ros2.bridge.ROS2SubscribeJointState"),
                ("ArticulationController", "isaacsim.core.nodes.IsaacArticulationController"),
            ],
            og.Controller.Keys.CONNECT: [
                ("OnImpulseEvent.outputs:execOut", "PublishJointState.inputs:execIn"),
                ("OnImpulseEvent.outputs:execOut", "SubscribeJointState.inputs:execIn"),
                ("OnImpulseEvent.outputs:execOut", "ArticulationController.inputs:execIn"),
                ("ReadSimTime.outputs:simulationTime", "PublishJointState.inputs:timeStamp"),
                ("SubscribeJointState.outputs:jointNames", "ArticulationController.inputs:jointNames"),
                ("SubscribeJointState.outputs:positionCommand", "ArticulationController.inputs:positionCommand"),
                ("SubscribeJointState.outputs:velocityCommand", "ArticulationController.inputs:velocityCommand"),
                ("SubscribeJointState.outputs:effortCommand", "ArticulationController.inputs:effortCommand"),
            ],
            og.Controller.Keys.SET_VALUES: [
                ("ArticulationController.inputs:robotPath", "/World/franka"),
                ("PublishJointState.inputs:targetPrim", [usdrt.Sdf.Path("/World/franka")]),
            ],
        },
    )
except Exception as e:
    print(e)
simulation_app.update()
world.initialize_physics()
world.play()
while simulation_app.is_running():
    world.step(render=True)
    og.Controller.set(og.Controller.attribute("/ActionGraph/OnImpulseEvent.state:enableImpulse"), True)
world.stop()
simulation_app.close()
