"""Robots that are added to a loaded world and taken out again, while the state of all others goes on.

MuJoCo has no place for another body in a model: a new one is compiled from the same scenery, and what moves in both takes its
state along, by name.
"""

from __future__ import annotations

import re

from graphengine.diagnostics import Findings
from graphengine.spec import RobotUse
from graphengine.world.fleet import place
from graphengine.world.model import LoadedWorld
from graphengine.world.prims import add_robot
from graphengine.world.scenery import body_names


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
            CheckError: with all that is wrong with it; nothing has changed then.
        """
        loaded = self._loaded
        span = loaded.scenery.scene.document.key_span("robots")
        placements = list(place(name, use))
        if len(placements) != 1 or placements[0].name != name:
            findings.add("G109", f"{name!r} is a fleet: robots are added one by one", span)
        elif not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name):
            findings.add("G109", f"{name!r} is not a name: letters, digits and '_', not beginning with a digit", span)
        elif name == "World" or f"/{name}" in loaded.stage:
            findings.add("S105", f"{name!r} is taken", span)
        findings.raise_errors()
        robot = loaded.scenery.robot(placements[0], findings)
        findings.raise_errors()
        assert robot is not None
        model = loaded.scenery.compile({**loaded.robots, name: robot}, findings)
        findings.raise_errors()
        assert model is not None
        add_robot(loaded.stage, robot, body_names(model), findings)
        if findings.errors:
            loaded.stage.remove(robot.prim_path)
            findings.raise_errors()
        loaded.robots[name] = robot
        loaded.simulation.continue_with(model)

    def remove(self, name: str) -> None:
        """Take one robot out; whoever still holds something of it holds nothing."""
        loaded = self._loaded
        robot = loaded.robots.pop(name)
        model = loaded.scenery.compile(loaded.robots, Findings())
        assert model is not None  # it is a part of one that compiled
        loaded.simulation.forget(robot.prim_path)
        loaded.stage.remove(robot.prim_path)
        loaded.simulation.continue_with(model)
