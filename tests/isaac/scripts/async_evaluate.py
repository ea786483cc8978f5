import asyncio

import omni.graph.core as og
import omni.kit.app
import omni.usd


async def setup():
    await omni.usd.get_context().new_stage_async()
    keys = og.Controller.Keys
    graph, nodes, _, _ = og.Controller.edit(
        {"graph_path": "/World/async", "evaluator_name": "execution"},
        {
            keys.CREATE_NODES: [("Tick", "omni.graph.action.OnTick"), ("Print", "omni.graph.action.Counter")],
            keys.CONNECT: [("Tick.outputs:tick", "Print.inputs:execIn")],
        },
    )
    await og.Controller.evaluate(graph)
    await omni.kit.app.get_app().next_update_async()
    for _ in range(10):
        await asyncio.sleep(0.1)
    og.Controller.evaluate_sync(graph)
    return nodes[1].get_attribute("outputs:count").get()


asyncio.ensure_future(setup())
