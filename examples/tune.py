"""Tune a position controller over 50 sessions of one scene: the gain that brings a robot soonest to a line 1 m ahead."""

from scipy.optimize import brute

import graphengine as ge

GOAL, DURATION, PERIOD = 1.0, 3.0, 0.1  # m, s, s
SESSIONS = 50


def cost(scene: ge.Scene, gain: float) -> float:
    """Distance from the goal, summed over the time, m s; what is beyond the goal counts tenfold."""
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
    """The best gain, 1/s, and its cost, m s."""
    scene = ge.load("dd100_flat")
    gain, least, _, _ = brute(
        lambda gains: cost(scene, gains[0]), [(0.5, 3.0)], Ns=SESSIONS, finish=None, full_output=True
    )
    print(f"gain {gain:.2f} 1/s: cost {least:.2f} m s, the least of {SESSIONS} sessions")
    return float(gain), float(least)


if __name__ == "__main__":
    main()
