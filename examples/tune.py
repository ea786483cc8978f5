"""Tunes the gain of a position controller over 50 sessions of one scene.

The controller drives a robot to a line 1 m ahead; the best gain gets it there soonest, without overshooting far.
"""

from scipy.optimize import brute

import graphengine as ge

GOAL, DURATION, PERIOD = 1.0, 3.0, 0.1  # m, s, s
SESSIONS = 50


def cost(scene: ge.Scene, gain: float) -> float:
    """Return the cost of a gain, m s: the distance from the goal, integrated over the drive; overshoot counts tenfold."""
    total = 0.0
    with scene.session() as sim:
        robot = sim.robots["dd100"]
        while sim.time < DURATION:
            missing = GOAL - robot.pose.position[0]
            total += PERIOD * (missing if missing > 0.0 else -10.0 * missing)
            robot.publish("cmd_vel", {"linear": {"x": gain * missing}})
            sim.run(PERIOD)
    return total


def main() -> tuple[float, float]:
    """Return the gain with the least cost, 1/s, and this cost, m s."""
    scene = ge.load("dd100_flat")
    gain, least, _, _ = brute(
        lambda gains: cost(scene, gains[0]), [(0.5, 3.0)], Ns=SESSIONS, finish=None, full_output=True
    )
    print(f"gain {gain:.2f} 1/s: cost {least:.2f} m s, the least of {SESSIONS} sessions")
    return float(gain), float(least)


if __name__ == "__main__":
    main()
