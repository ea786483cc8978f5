"""What ten expectations cost a tick of a scene: sessions with and without them, in turns of half a second in one process.

`python tests/bench/expectations.py [ROUNDS] [RAYS]` prints the milliseconds a tick, and the median of the ratios of neighbouring
turns. All sessions drive, and have a subscription of the scan, as other programs would; a second session without expectations
shows how far chance goes. Nothing is asserted.
"""

from __future__ import annotations

import itertools
import statistics
import sys
import time
from contextlib import ExitStack
from typing import Any

import graphengine as ge

TICKS = 30
"""Ticks of a turn."""
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


def main(rounds: int, rays: Any) -> None:
    """Run and print."""
    times: dict[str, list[float]] = {name: [] for name in ("without", "again", "with")}
    with ExitStack() as stack:
        sessions = {name: stack.enter_context(ge.load("dd100_warehouse", rays=rays).session()) for name in times}
        for session in sessions.values():
            session.subscribe(SCAN, keep=1)
            session.subscribe(ODOM, keep=1)
            session.publish("/dd100_0000/cmd_vel", {"linear": {"x": 0.3}, "angular": {"z": 0.5}}, every=0.1)
        checks = sessions["with"].expect(*EXPECTATIONS)
        for turn in range(rounds + 2):
            for name, session in itertools.islice(itertools.cycle(sessions.items()), turn % 3, turn % 3 + 3):
                start = time.process_time()
                session.run(TICKS / 60.0)
                times[name].append((time.process_time() - start) / TICKS * 1e3)
        assert {check.outcome for check in checks} == {"open"}, [check.report() for check in checks]
    base = times["without"][2:]
    print(f"dd100_warehouse: {statistics.median(base):.3f} ms a tick without expectations")
    for name in ("again", "with"):
        ratio = statistics.median(one / other for one, other in zip(times[name][2:], base, strict=True))
        print(f"{name:8}{statistics.median(times[name][2:]):.3f} ms a tick, {100 * (ratio - 1):+.1f} %")


if __name__ == "__main__":
    main(int((sys.argv[1:2] or ["60"])[0]), (sys.argv[2:3] or ["auto"])[0])
