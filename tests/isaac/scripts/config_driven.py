from dataclasses import dataclass, field
from typing import Dict, List

import omni.graph.core as og


@dataclass
class Topic:
    kind: str
    name: str
    extra: Dict[str, object] = field(default_factory=dict)


TOPICS: List[Topic] = [
    Topic("ROS2SubscribeTwist", "cmd_vel", {"queueSize": 1}),
    Topic("ROS2SubscribeAckermannDrive", "ackermann"),
    Topic("ROS2PublishClock", "clock"),
]
COMMON = {"graph_path": "/World/config", "evaluator_name": "execution"}
base = {og.Controller.Keys.CREATE_NODES: [("Tick", "omni.graph.action.OnPlaybackTick")]}
og.Controller.edit({**COMMON}, base)
for topic in TOPICS:
    if not (type_name := f"isaacsim.ros2.bridge.{topic.kind}"):
        continue
    node = topic.name.title().replace("_", "")
    og.Controller.edit(
        COMMON["graph_path"],
        {
            og.Controller.Keys.CREATE_NODES: [(node, type_name)],
            og.Controller.Keys.CONNECT: [("Tick.outputs:tick", f"{node}.inputs:execIn")],
            og.Controller.Keys.SET_VALUES: [
                (f"{node}.inputs:topicName", topic.name),
                *[(f"{node}.inputs:{k}", v) for k, v in topic.extra.items()],
            ],
        },
    )
