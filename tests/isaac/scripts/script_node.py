import omni.graph.core as og

CODE = """
def compute(db):
    db.outputs.command = [db.inputs.speed, db.inputs.speed]
    return True
"""
keys = og.Controller.Keys
og.Controller.edit(
    {"graph_path": "/World/script", "evaluator_name": "execution"},
    {
        keys.CREATE_NODES: [
            ("Tick", "omni.graph.action.OnPlaybackTick"),
            ("Script", "omni.graph.scriptnode.ScriptNode"),
            ("Move", "isaacsim.core.nodes.IsaacArticulationController"),
        ],
        keys.CREATE_ATTRIBUTES: [
            ("Script.inputs:speed", "double"),
            ("Script.outputs:command", "double[]"),
        ],
        keys.SET_VALUES: [
            ("Script.inputs:script", CODE),
            ("Script.inputs:speed", 2.5),
            ("Move.inputs:robotPath", "/World/robot"),
        ],
        keys.CONNECT: [
            ("Tick.outputs:tick", "Script.inputs:execIn"),
            ("Script.outputs:execOut", "Move.inputs:execIn"),
            ("Script.outputs:command", "Move.inputs:velocityCommand"),
        ],
    },
)
