from omni.isaac.kit import SimulationApp

kit = SimulationApp({"headless": False})
import omni
import omni.graph.core as og

og.Controller.edit(
    {"graph_path": "/World/loop", "evaluator_name": "execution"},
    {"create_nodes": [("Tick", "omni.graph.action.OnPlaybackTick")]},
)
omni.timeline.get_timeline_interface().play()
while True:
    kit.update()
kit.close()
