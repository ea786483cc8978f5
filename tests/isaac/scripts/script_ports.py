import omni.graph.core as og

CODE = """
def compute(db):
    db.outputs.doubled = 2 * db.inputs.value
    db.outputs.done = db.inputs.trigger
"""
keys = og.Controller.Keys
og.Controller.edit(
    {"graph_path": "/World/ports", "evaluator_name": "execution"},
    {
        keys.CREATE_NODES: [
            ("Tick", "omni.graph.action.OnPlaybackTick"),
            ("Script", "omni.graph.scriptnode.ScriptNode"),
            ("Clock", "isaacsim.ros2.bridge.ROS2PublishClock"),
        ],
        keys.CREATE_ATTRIBUTES: [
            ("Script.inputs:trigger", "execution"),
            ("Script.outputs:done", "execution"),
            ("Script.inputs:value", "any"),
            ("Script.outputs:doubled", "any"),
        ],
        keys.SET_VALUES: ("Script.inputs:script", CODE),
        keys.CONNECT: [
            ("Tick.outputs:tick", "Script.inputs:trigger"),
            ("Tick.outputs:time", "Script.inputs:value"),
            ("Script.outputs:done", "Clock.inputs:execIn"),
            ("Script.outputs:doubled", "Clock.inputs:timeStamp"),
        ],
    },
)
