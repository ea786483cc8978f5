import asyncio

import omni.ext
import omni.graph.core as og
import omni.kit.app
import omni.ui as ui
import omni.usd


class Extension(omni.ext.IExt):
    """Builds its graph as soon as it starts."""

    GRAPH = "/World/from_extension"

    def on_startup(self, ext_id: str):
        self._window = ui.Window("Robot", width=300, visible=True)
        with self._window.frame, ui.VStack():
            ui.Button("Build", clicked_fn=self._build)
        self._events = omni.usd.get_context().get_stage_event_stream().create_subscription_to_pop(self._on_stage)
        asyncio.ensure_future(self._build_later())

    async def _build_later(self):
        await omni.kit.app.get_app().next_update_async()
        self._build()

    def _on_stage(self, event):
        if event.type == int(omni.usd.StageEventType.OPENED):
            self._build()

    def _build(self, rate: int = 2):
        stage = omni.usd.get_context().get_stage()
        if stage.GetPrimAtPath(self.GRAPH):
            stage.RemovePrim(self.GRAPH)
        keys = og.Controller.Keys
        og.Controller.edit(
            {"graph_path": self.GRAPH, "evaluator_name": "execution"},
            {
                keys.CREATE_NODES: [
                    ("OnTick", "omni.graph.action.OnPlaybackTick"),
                    ("Gate", "isaacsim.core.nodes.IsaacSimulationGate"),
                    ("Clock", "isaacsim.ros2.bridge.ROS2PublishClock"),
                ],
                keys.SET_VALUES: [("Gate.inputs:step", rate)],
                keys.CONNECT: [
                    ("OnTick.outputs:tick", "Gate.inputs:execIn"),
                    ("Gate.outputs:execOut", "Clock.inputs:execIn"),
                ],
            },
        )

    def on_shutdown(self):
        self._events = None


if __name__ == "__main__":
    extension = Extension()
    extension.on_startup("robot.tools-1.0.0")
    extension.on_shutdown()
