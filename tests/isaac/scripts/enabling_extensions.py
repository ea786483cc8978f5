import omni.kit.app
from isaacsim.core.utils.extensions import enable_extension

manager = omni.kit.app.get_app().get_extension_manager()
manager.set_extension_enabled_immediate("isaacsim.ros2.bridge", True)
enable_extension("omni.graph.window.action")
if not manager.is_extension_enabled("isaacsim.ros2.bridge"):
    print("the bridge is not enabled yet")

import omni.graph.core as og  # only there once the extension is

og.Controller.edit(
    {"graph_path": "/World/tf", "evaluator_name": "execution"},
    {
        og.Controller.Keys.CREATE_NODES: [
            ("OnTick", "omni.graph.action.OnPlaybackTick"),
            ("Tf", "isaacsim.ros2.bridge.ROS2PublishRawTransformTree"),
        ],
        og.Controller.Keys.CONNECT: [("OnTick.outputs:tick", "Tf.inputs:execIn")],
        og.Controller.Keys.SET_VALUES: [
            ("Tf.inputs:translation", (1, 2, 0.5)),
            ("Tf.inputs:rotation", (0.0, 0.0, 0.7071067811865476, 0.7071067811865476)),
        ],
    },
)
