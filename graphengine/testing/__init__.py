"""Tools for tests of nodes and graphs.

`RecordingContext` runs a single node without a session: its world consists of stubs for robots and devices, and its transport
keeps messages in memory. `check_node` checks that a node class is documented, declared correctly and deterministic. A test:

    context = RecordingContext()
    robot = context.world.add_robot("/dd100", ["left", "right"])
    node = IsaacArticulationController(robot_path="/dd100", velocity_command=np.array([1.0, 2.0]))
    node.setup(context)
    node.compute()
    assert robot.targets["velocity"] == [1.0, 2.0]

`context.transport.messages("/odom")` returns the messages that the node published on a topic;
`context.transport.inject("/cmd_vel", twist)` sends a message to the node.

For tests of graphs, `session` starts a session of a scene, and `session_fixture` makes a pytest fixture that starts one.
"""

from __future__ import annotations

from graphengine.testing.node_check import check_node as check_node
from graphengine.testing.recording_context import RecordingContext as RecordingContext
from graphengine.testing.recording_world import RecordingEntities as RecordingEntities
from graphengine.testing.recording_world import RecordingWorld as RecordingWorld
from graphengine.testing.sessions import session as session
from graphengine.testing.sessions import session_fixture as session_fixture
