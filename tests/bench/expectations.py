"""What ten expectations cost a tick of a scene with dd100: sessions with and without them, in turns of half a second.

`python tests/bench/expectations.py [ROUNDS] [RAYS] [SCENE]` prints the milliseconds a tick, and the median of the ratios of
neighbouring turns. All sessions drive, and have a subscription of the scan, as other programs would; a second session without
expectations shows how far chance goes. Nothing is asserted.
"""

from __future__ import annotations

import sys
from contextlib import ExitStack
from typing import Any

import graphengine as ge
from tests.bench.turns import compare

ODOM, SCAN = "/dd100_0000/odom", "/dd100_0000/sim_lidar/scan"
EXPECTATIONS = (
    ge.always("tilt('dd100') < 0.5"),
    ge.never("contact('dd100', '/World/racks/*')"),
    ge.always("abs(velocity('dd100').linear[0]) < 2 and abs(velocity('dd100').angular[2]) < 3"),
    ge.within(1e6, "distance('dd100', [100, 100]) < 0.1"),
    ge.until("pose('dd100').position[2] < 1", "pose('dd100').position[0] > 100"),
    ge.holds(1e6, "hypot(pose('dd100').position[0], pose('dd100').position[1]) > 1e-6"),
    ge.settles(1e6, "port('dd100/joint_states/ComputeOdom.linearVelocity')[0] < 2"),
    ge.count("velocity('dd100').linear[0] > 0.25", at_most=1_000_000),
    ge.always(f"message('{ODOM}').twist.twist.linear.x < 2"),
    ge.rate(SCAN, at_least=1.0),
)


def main(rounds: int, rays: Any, scene: str) -> None:
    """Run and print."""
    with ExitStack() as stack:
        sides = {}
        for name in ("without expectations", "again", "with"):
            session = stack.enter_context(ge.load(scene, rays=rays).session())
            session.subscribe(SCAN, keep=1)
            session.subscribe(ODOM, keep=1)
            session.publish("/dd100_0000/cmd_vel", {"linear": {"x": 0.3}, "angular": {"z": 0.5}}, every=0.1)
            checks = session.expect(*EXPECTATIONS) if name == "with" else ()
            sides[name] = lambda ticks, run=session.run: run(ticks / 60.0)
        compare(scene, sides, rounds)
        assert {check.outcome for check in checks} == {"open"}, [check.report() for check in checks]


if __name__ == "__main__":
    given = [*sys.argv[1:], *("60", "auto", "dd100_warehouse")[len(sys.argv) - 1 :]]
    main(int(given[0]), given[1], given[2])
