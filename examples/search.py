"""Searches for the turn rate that brings a robot nearest to a goal in two seconds; each try starts from a checkpoint."""

import math

import graphengine as ge

GOAL = (0.6, 0.5)  # m, from the start
SPEED, DURATION = 0.5, 2.0  # m/s, s
TURNS = [0.2 * step for step in range(9)]  # rad/s


def miss(sim: ge.Session, start: tuple[float, ...], turn: float) -> float:
    """Drive with a constant twist and return the distance from the robot to the goal afterwards, m."""
    robot = sim.robots["dd100"]
    drive = robot.publish("cmd_vel", {"linear": {"x": SPEED}, "angular": {"z": turn}}, every=0.1)
    sim.run(DURATION)
    drive.close()
    x, y, _ = robot.pose.position
    return math.hypot(x - start[0] - GOAL[0], y - start[1] - GOAL[1])


def main() -> tuple[float, float]:
    """Try all turn rates; return the best one, rad/s, and the robot's distance from the goal after it, m."""
    with ge.load("dd100_flat").session() as sim:
        sim.run(0.5)
        start = sim.robots["dd100"].pose.position
        mark = sim.checkpoint()
        misses = {}
        for turn in TURNS:
            sim.restore(mark)
            misses[turn] = miss(sim, start, turn)
        best = min(misses, key=lambda turn: misses[turn])
    print(f"{best:.1f} rad/s: {misses[best]:.2f} m from the goal, the nearest of {len(misses)} drives")
    return best, misses[best]


if __name__ == "__main__":
    main()
