import omni.graph.core as og
import omni.usd
from isaacsim import SimulationApp

app = SimulationApp()
omni.usd.get_context().open_stage("omniverse://localhost/carter.usd", None)
camera = "/World/Carter/front_camera/render_product"
og.Controller.set(og.Controller.attribute(camera + ".inputs:enabled"), True)
og.Controller.attribute("/World/Carter/rear_camera/render_product.inputs:enabled").set(True)
og.Controller.edit(
    {"graph_path": "/World/clock", "evaluator_name": "execution"},
    {
        "create_nodes": [("t", "omni.graph.action.OnPlaybackTick"), ("c", "isaacsim.ros2.bridge.ROS2PublishClock")],
        "connect": [("t.outputs:tick", "c.inputs:execIn")],
    },
)
og.Controller.edit("/World/Carter/drive", {"set_values": [("odometry.inputs:chassisPrim", "/World/Carter")]})
