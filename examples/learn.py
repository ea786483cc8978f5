"""Learns to drive a robot to a point: the cross-entropy method in a Gymnasium environment (needs the extra `gym`)."""

import numpy as np
from numpy.typing import NDArray

import graphengine as ge

GOAL, STEPS, TRIES, BEST, ROUNDS = np.array([1.0, 1.0]), 30, 12, 3, 5  # m; numbers of steps, tries, best tries, rounds


def goal(sim: ge.Session) -> NDArray[np.float64]:
    """Return the goal in the robot's frame: forwards and to the left, m."""
    pose = sim.robots["dd100"].pose
    (x, y), yaw = GOAL - pose.position[:2], 2.0 * np.arctan2(pose.orientation[2], pose.orientation[3])
    return np.array([x * np.cos(yaw) + y * np.sin(yaw), y * np.cos(yaw) - x * np.sin(yaw)])


def total(env: ge.gym.SceneEnv, gains: NDArray[np.float64]) -> float:
    """Return the sum of the rewards of an episode whose action is a linear function of the observation."""
    env.reset(seed=0)
    return sum(env.step(gains.reshape(2, 2) @ env.observation)[1] for _ in range(STEPS))


def main(seed: int = 0) -> None:
    """Learn the gains, and print the distance from the goal at the end of an episode after each round, m."""
    drive = ge.gym.BaseVelocity("/dd100_0000/cmd_vel", linear=1.0, angular=2.0)  # m/s, rad/s
    seen, random = ge.gym.Observation(goal, low=-5.0, high=5.0), np.random.default_rng(seed)
    env = ge.gym.SceneEnv(
        ge.load("dd100_flat"), action=drive, observation=seen, reward=lambda env: -np.hypot(*env.observation), ticks=12
    )
    mean, spread = np.zeros(4), np.ones(4)
    for _ in range(ROUNDS):
        best = sorted(random.normal(mean, spread, (TRIES, 4)), key=lambda gains: total(env, gains))[-BEST:]
        mean, spread = np.mean(best, axis=0), np.std(best, axis=0) + 0.1
        print(f"reward {total(env, mean):.1f}, at the end {np.hypot(*env.observation):.2f} m from the goal")
    env.close()


if __name__ == "__main__":
    main()
