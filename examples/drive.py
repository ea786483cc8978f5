"""Drive a robot for five seconds and read its odometry."""

import graphengine as ge
from graphengine.messages.messages import Odometry


def main() -> float:
    """Drive the robot and return the distance from the start to its last odometry position, m."""
    scene = ge.load("dd100_warehouse")
    with scene.session() as sim:
        robot = sim.robots["dd100"]
        start = robot.pose.position
        odom = sim.subscribe(f"/{robot.namespace}/odom", Odometry)
        robot.publish("cmd_vel", {"linear": {"x": 0.5}, "angular": {"z": 0.1}}, every=0.1)
        sim.run(5.0)
        assert odom.latest is not None
        position = odom.latest.pose.pose.position
        print(f"odometry: x = {position.x:.2f} m, y = {position.y:.2f} m, from {len(odom)} messages")
        print(f"world: from {start[:2]} to {robot.pose.position[:2]}")
        return float((position.x**2 + position.y**2) ** 0.5)


if __name__ == "__main__":
    main()
