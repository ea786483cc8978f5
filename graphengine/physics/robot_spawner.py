"""Robots that are added to a loaded world and taken out again, while the state of all others goes on.

MuJoCo has no place for another body in a model: a new one is compiled from the same scenery, and what moves in both takes its
state along, by name.
"""

from __future__ import annotations

import re
from dataclasses import replace

from graphengine.format.diagnostics import Findings
from graphengine.format.spec import RobotUse
from graphengine.physics.loading import LoadedWorld
from graphengine.physics.model.fleet_expansion import RobotPlacement, place
from graphengine.physics.model.robot_prims import add_robot
from graphengine.physics.model.scenery import body_names


class Population:
    """The robots of a world.

    Args:
        loaded: the world; its `robots` and its stage follow what is added and removed.
    """

    def __init__(self, loaded: LoadedWorld) -> None:
        self._loaded = loaded

    def add(self, name: str, use: RobotUse, findings: Findings) -> None:
        """Put one robot at its place, at rest.

        Raises:
            CheckError: with all that is wrong with it.
            PhysicsError: it cannot be where it was put.
            UsageError: rays that were asked for cannot meet it. After an error of any kind all is as it was.
        """
        self.put(self._placement(name, use, findings), findings)
        self._loaded.stage.find(self._loaded.robots[name].prim_path).facts["spawned"] = True

    def put(self, placement: RobotPlacement, findings: Findings) -> None:
        """The same for a place that was found before."""
        loaded, name = self._loaded, placement.name
        loaded.scenery.forget(loaded.robots)
        robot = loaded.scenery.robot(placement, findings)
        findings.raise_errors()
        assert robot is not None
        model = loaded.scenery.compile({**loaded.robots, name: robot}, findings)
        findings.raise_errors()
        assert model is not None
        try:
            add_robot(loaded.stage, robot, body_names(model), findings)
            findings.raise_errors()
            loaded.simulation.continue_with(model)
        except BaseException:
            loaded.stage.remove(robot.prim_path)
            raise
        loaded.robots[name] = robot

    def _placement(self, name: str, use: RobotUse, findings: Findings) -> RobotPlacement:
        """Where a robot is to be put; nothing else has its name."""
        placement, *others = place(name, use)
        if others or placement.name != name:
            findings.add("G109", f"{name!r} is a fleet: robots are added one by one")
        elif not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name):
            findings.add("G109", f"{name!r} is not a name: letters, digits and '_', not beginning with a digit")
        elif name in {one.name for one in self._loaded.simulation.entities.all()}:
            findings.add("S105", f"{name!r} is taken")
        elif (taken := self._loaded.stage.obstacle(placement.prim_path)) is not None:
            findings.add(
                "S105",
                f"{name!r} is taken: {taken.path} is a {taken.kind}, and the robot is to be at {placement.prim_path}",
            )
        findings.raise_errors()
        return replace(placement, key="")

    def remove(self, name: str) -> None:
        """Take one robot out; whoever still holds something of it holds nothing."""
        loaded = self._loaded
        others = {other: robot for other, robot in loaded.robots.items() if other != name}
        model = loaded.scenery.compile(others, Findings())
        assert model is not None  # it is a part of one that compiled
        robot = loaded.robots.pop(name)
        loaded.simulation.forget(robot.prim_path)
        loaded.stage.remove(robot.prim_path)
        loaded.simulation.continue_with(model)
