"""Command the wheels of a robot: drive towards a wall until the lidar measures half a metre, twice."""

from pathlib import Path

import numpy as np

import graphengine as ge

SCENE = {
    "scene": "hall",
    "world": "worlds/full_warehouse.xml",
    "robots": {"dingo": {"use": "bare_dingo.yaml", "position": [-3.0, 6.0, 0.025]}},
}
WHEELS = ["front_left_wheel_joint", "front_right_wheel_joint"]
RADIUS = 0.049  # m, of a wheel


def main() -> list[float]:
    """Return the distances to the wall at which the robot stops, m."""
    stops: list[float] = []
    with ge.load(SCENE, folder=Path(__file__).parent).session() as sim:
        robot = sim.robots["dingo"]
        lidar = robot.sensors["sim_lidar"]
        for fastest in (0.5, 1.0):  # m/s
            robot.reset()
            start, ahead = sim.time, np.inf
            while ahead > 0.51:
                speed = min(fastest, ahead - 0.5)
                robot.command(velocities=[speed / RADIUS] * 2, joints=WHEELS)
                sim.step()
                if (scan := lidar.sample()) is not None:
                    ahead = float(scan.ranges[np.abs(scan.directions[:, 1]) < 0.2].min())
            stops.append(ahead)
            print(f"{fastest} m/s: {ahead:.2f} m before the wall after {sim.time - start:.1f} s")
    return stops


if __name__ == "__main__":
    main()
