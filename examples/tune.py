"""Tunes the gain of a position controller over 50 sessions of one scene.

The controller drives a robot to a line 1 m ahead; the best gain gets it there soonest, without overshooting far.
"""

import graphengine as ge

GOAL, DURATION, PERIOD = 1.0, 3.0, 0.1  # m, s, s
GAINS = [0.5 + 0.05 * step for step in range(50)]  # 1/s


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
    costs = {gain: cost(scene, gain) for gain in GAINS}
    best = min(costs, key=lambda gain: costs[gain])
    print(f"gain {best:.2f} 1/s: cost {costs[best]:.2f} m s, the least of {len(costs)} sessions")
    return best, costs[best]


if __name__ == "__main__":
    main()
