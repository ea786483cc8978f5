import omni.graph.core as og
import omni.usd
from pxr import Sdf

stage = omni.usd.get_context().get_stage()
for number, name in enumerate(("alpha", "beta")):
    robot = f"/World/{name}_{number:02d}"
    path = f"{robot}/tf"
    if stage.GetPrimAtPath(path).IsValid():
        stage.RemovePrim(path)
    stage.DefinePrim(f"{robot}/frames", "Xform")
    og.Controller.edit(
        {"graph_path": path, "evaluator_name": "execution"},
        {
            og.Controller.Keys.CREATE_NODES: [
                ("Tick", "omni.graph.action.OnPlaybackTick"),
                ("Tree", "isaacsim.core.nodes.IsaacComputeTransformTree"),
                ("Tf", "isaacsim.ros2.bridge.ROS2PublishTransformTree"),
            ],
            og.Controller.Keys.SET_VALUES: [
                ("Tree.inputs:parentPrim", Sdf.Path(robot)),
                ("Tree.inputs:targetPrims", [Sdf.Path(robot).AppendChild(link) for link in ("camera", "lidar")]),
            ],
            og.Controller.Keys.CONNECT: [
                ("Tick.outputs:tick", "Tree.inputs:execIn"),
                ("Tree.outputs:execOut", "Tf.inputs:execIn"),
                *((f"Tree.outputs:{port}", f"Tf.inputs:{port}")
                  for port in ("childFrames", "parentFrames", "orientations", "translations")),
            ],
        },
    )
