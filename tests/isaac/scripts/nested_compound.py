import omni.graph.core as og

keys = og.Controller.Keys
controller = og.Controller(update_usd=True, undoable=False)
plus_one = {
    keys.CREATE_NODES: [("Add", "omni.graph.nodes.Add"), ("One", "omni.graph.nodes.ConstantDouble")],
    keys.CONNECT: [("One.inputs:value", "Add.inputs:b")],
    keys.SET_VALUES: [("One.inputs:value", 1.0)],
    keys.PROMOTE_ATTRIBUTES: [("Add.inputs:a", "inputs:x"), ("Add.outputs:sum", "outputs:y")],
}
telling = {
    keys.CREATE_NODES: [
        ("PlusOne", plus_one),
        ("Text", "omni.graph.nodes.ToString"),
        ("Print", "omni.graph.ui_nodes.PrintText"),
    ],
    keys.CONNECT: [("PlusOne.outputs:y", "Text.inputs:value"), ("Text.outputs:converted", "Print.inputs:text")],
    keys.PROMOTE_ATTRIBUTES: [("PlusOne.inputs:x", "inputs:x"), ("Print.inputs:execIn", "inputs:execIn")],
}
_, _, _, names = controller.edit(
    {"graph_path": "/World/nested", "evaluator_name": "execution"},
    {
        keys.CREATE_NODES: [("Tick", "omni.graph.action.OnPlaybackTick"), ("Tell", telling)],
        keys.CONNECT: [("Tick.outputs:deltaSeconds", "Tell.inputs:x"), ("Tick.outputs:tick", "Tell.inputs:execIn")],
    },
)
assert names["Tell"].get_prim_path() == "/World/nested/Tell"
