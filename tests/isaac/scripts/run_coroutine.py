from isaacsim import SimulationApp

simulation_app = SimulationApp({"headless": True})

import isaacsim.core.experimental.utils.stage as stage_utils  # noqa: E402
import omni.graph.core as og  # noqa: E402
import omni.kit.app  # noqa: E402
from omni.kit.async_engine import run_coroutine  # noqa: E402


async def build(path: str = "/World/awaited"):
    await stage_utils.create_new_stage_async()
    await omni.kit.app.get_app().next_update_async()
    og.Controller.edit(
        {"graph_path": path, "evaluator_name": "execution"},
        {
            "create_nodes": [("t", "omni.graph.action.OnPlaybackTick"), ("c", "isaacsim.ros2.bridge.ROS2PublishClock")],
            "connect": [("t.outputs:tick", "c.inputs:execIn")],
        },
    )
    return path


path = simulation_app.run_coroutine(build())
og.Controller.set(og.Controller.attribute(f"{path}/c.inputs:topicName"), "sim_clock")
run_coroutine(build("/World/awaited_too"))
