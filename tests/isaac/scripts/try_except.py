import traceback

import omni.graph.core as og

try:
    og.Controller.edit("/World/broken", {og.Controller.Keys.CONNECT: [("Nobody.outputs:tick", "Nothing.inputs:execIn")]})
except Exception:
    traceback.print_exc()

try:
    og.Controller.edit(
        {"graph_path": "/World/good", "evaluator_name": "execution"},
        {og.Controller.Keys.CREATE_NODES: [("Event", "omni.graph.action.OnCustomEvent")],
         og.Controller.Keys.SET_VALUES: [("Event.inputs:eventName", "go")]},
    )
except og.OmniGraphError as error:
    print(error)
    raise
finally:
    print("done")
