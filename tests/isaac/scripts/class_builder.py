import omni.graph.core as og


class Bridge:
    """Builds the ROS 2 graphs of one robot."""

    TICK = ("OnTick", "omni.graph.action.OnPlaybackTick")

    def __init__(self, robot: str, namespace: str = "") -> None:
        self.robot = robot
        self.namespace = namespace
        self.graphs = []

    def path(self, name: str) -> str:
        return "/".join((self.robot, "graphs", name))

    def add(self, name, nodes, wires, values=()):
        keys = og.Controller.Keys
        graph, *_ = og.Controller.edit(
            {"graph_path": self.path(name), "evaluator_name": "execution"},
            {
                keys.CREATE_NODES: [self.TICK, *nodes],
                keys.CONNECT: [("OnTick.outputs:tick", f"{nodes[0][0]}.inputs:execIn"), *wires],
                keys.SET_VALUES: [(key, value) for key, value in values],
            },
        )
        self.graphs.append(graph)
        return self

    def build(self):
        self.add("joints", [("Joints", "isaacsim.ros2.bridge.ROS2PublishJointState")], [],
                 {"Joints.inputs:targetPrim": self.robot, "Joints.inputs:nodeNamespace": self.namespace}.items())
        self.add("drive", [("Ackermann", "isaacsim.ros2.bridge.ROS2SubscribeAckermannDrive")], [],
                 [("Ackermann.inputs:topicName", "ackermann_cmd")])
        return self.graphs


assert len(Bridge("/World/leatherback", namespace="car").build()) == 2
