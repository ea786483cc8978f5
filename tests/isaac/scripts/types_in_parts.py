import omni.graph.core as og

DOUBLE = og.BaseDataType.DOUBLE
graph, _, _, _ = og.Controller.edit(
    {"graph_path": "/World/types", "evaluator_name": "execution"},
    {
        og.Controller.Keys.CREATE_VARIABLES: [
            ("gain", og.Type(DOUBLE)),
            ("names", og.Type(og.BaseDataType.TOKEN, 1, 1)),
            ("goal", og.Type(DOUBLE, 3, 0, og.AttributeRole.POSITION)),
        ],
        og.Controller.Keys.CREATE_NODES: [
            ("tick", "omni.graph.action.OnPlaybackTick"),
            ("script", "omni.graph.scriptnode.ScriptNode"),
        ],
        og.Controller.Keys.CREATE_ATTRIBUTES: [
            ("script.inputs:velocity", og.Type(DOUBLE, 3)),
            ("script.ok", ("bool", og.AttributePortType.ATTRIBUTE_PORT_TYPE_OUTPUT)),
        ],
        og.Controller.Keys.CONNECT: [("tick.outputs:tick", "script.inputs:execIn")],
        og.Controller.Keys.SET_VALUES: [
            ("script.inputs:script", "def compute(db):\n    db.outputs.ok = True\n"),
            ("script.inputs:velocity", (1, 2, 3)),
        ],
    },
)
late = graph.create_variable("late", og.AttributeType.type_from_ogn_type_name("colorf[3]"))
og.Controller.set_variable_default_value(late, (0.5, 1, 0))
og.Controller.set_variable_default_value(("names", graph), ["left", "right"])
graph.find_variable("gain").set(graph.get_context(), 0.25)
og.Controller.create_attribute(
    "/World/types/script", "wheels", og.Type(DOUBLE, 1, 1), og.AttributePortType.ATTRIBUTE_PORT_TYPE_OUTPUT
)
