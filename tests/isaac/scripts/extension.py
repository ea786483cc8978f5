import omni.ext
import omni.graph.core as og
import omni.ui as ui


class RobotExtension(omni.ext.IExt):
    """Builds its graph when somebody presses a button."""

    def on_startup(self, ext_id):
        self._window = ui.Window("Robot", width=300, height=100)
        with self._window.frame:
            ui.Button("Build", clicked_fn=self.build)

    def build(self):
        og.Controller.edit("/World/button", {"create_nodes": [("Tick", "omni.graph.action.OnTick")]})

    def on_shutdown(self):
        self._window = None
