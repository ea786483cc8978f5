"""A scene's physics, to which robots are added and from which they are removed while the state of all others goes on.

MuJoCo has no place for another body in a model: a new one is compiled from the same scenery, and what moves in both takes its
state along, by name.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

from graphengine.devices.stage import Stage
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files
from graphengine.format.spec import RobotUse
from graphengine.physics.engine import body_names, model_bytes
from graphengine.physics.model.fleet_expansion import RobotPlacement, place
from graphengine.physics.model.robot import RobotInstance
from graphengine.physics.model.robot_prims import add_robot
from graphengine.physics.model.scenery import Scenery
from graphengine.physics.simulation import Simulation


@dataclass(frozen=True, slots=True)
class LoadedWorld:
    """A scene that compiled.

    Attributes:
        simulation: physics and sensors, a `backend.World`.
        robots: by name, in order of the scene file, then in the order in which they were added.
        scenery: what the model was compiled from; other sets of robots compile from it too.
    """

    simulation: Simulation
    robots: dict[str, RobotInstance]
    scenery: Scenery

    @property
    def stage(self) -> Stage:
        """Prims of robots and of the world; graphs are not among them."""
        return self.simulation.stage

    def copy(self, files: Files, seed: int) -> LoadedWorld:
        """An independent world that begins as this one, which has not been stepped.

        Args:
            files: where the references of robots that are added may lead.
            seed: of the sensors' noise.
        """
        return LoadedWorld(self.simulation.copy(seed), dict(self.robots), self.scenery.copy(files))

    def begins_as(self, other: LoadedWorld) -> bool:
        """Return whether another world, possibly read from other files, has the same initial state."""
        return list(self.robots) == list(other.robots) and self.simulation.begins_as(other.simulation)

    def reread(self, fresh: LoadedWorld, files: Files) -> LoadedWorld | None:
        """Return this running world with new robot descriptions; None if a description now gives a different robot.

        Args:
            fresh: world with the same initial state as this one, read from the changed files.
            files: files that the descriptions of spawned robots may refer to.

        Raises:
            CheckError: the description of a spawned robot has errors.
        """
        scenery, findings, added = fresh.scenery.copy(files), Findings(), dict[str, RobotInstance]()
        for name, robot in self.robots.items():
            if name not in fresh.robots or self.stage.find(robot.prim_path).facts.get("spawned"):
                again = scenery.robot(robot.placement, findings)
                findings.raise_errors()
                assert again is not None
                added[name] = again
        robots = {name: added.get(name) or fresh.robots[name] for name in self.robots}
        if added and not self._is_made_of(scenery, robots):
            return None
        return LoadedWorld(self.simulation, robots, scenery)

    def _is_made_of(self, scenery: Scenery, robots: dict[str, RobotInstance]) -> bool:
        """Return whether the robots of another scenery give the same model and prims."""
        made: list[tuple[Stage, bytes]] = []
        for source, ones in ((self.scenery, self.robots), (scenery, robots)):
            model, stage = source.compile(ones, Findings()), Stage()
            if model is None:
                return False
            for robot in ones.values():
                add_robot(stage, robot, set(body_names(model)), Findings())
            made.append((stage, model_bytes(model)))
        (prims, model_before), (prims_again, model_again) = made
        return prims.is_like(prims_again) and model_before == model_again

    def add(self, name: str, use: RobotUse) -> None:
        """Add a robot at its place, at rest.

        Raises:
            CheckError: with all that is wrong with it.
            PhysicsError: it cannot be where it was put.
            UsageError: rays that were asked for cannot meet it. After an error of any kind all is as it was.
        """
        self.put(self._placement(name, use))
        self.stage.find(self.robots[name].prim_path).facts["spawned"] = True

    def put(self, placement: RobotPlacement) -> None:
        """The same for a place that was found before."""
        findings = Findings()
        self.scenery.forget(self.robots)
        robot = self.scenery.robot(placement, findings)
        findings.raise_errors()
        assert robot is not None
        model = self.scenery.compile({**self.robots, robot.name: robot}, findings)
        findings.raise_errors()
        assert model is not None
        try:
            add_robot(self.stage, robot, set(body_names(model)), findings)
            findings.raise_errors()
            self.simulation.continue_with(model)
        except BaseException:
            self.stage.remove(robot.prim_path)
            raise
        self.robots[robot.name] = robot

    def _placement(self, name: str, use: RobotUse) -> RobotPlacement:
        """Where a robot is to be put; nothing else has its name."""
        findings = Findings()
        placement, *others = place(name, use)
        if others or placement.name != name:
            findings.add("G109", f"{name!r} is a fleet: robots are added one by one")
        elif not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name):
            findings.add("G109", f"{name!r} is not a name: letters, digits and '_', not beginning with a digit")
        elif name in {one.name for one in self.simulation.entities.all()}:
            findings.add("S105", f"{name!r} is taken")
        elif (taken := self.stage.obstacle(placement.prim_path)) is not None:
            findings.add(
                "S105",
                f"{name!r} is taken: {taken.path} is a {taken.kind}, and the robot is to be at {placement.prim_path}",
            )
        findings.raise_errors()
        return replace(placement, key="")

    def remove(self, name: str) -> None:
        """Remove a robot. Handles to it become invalid."""
        others = {other: robot for other, robot in self.robots.items() if other != name}
        model = self.scenery.compile(others, Findings())
        assert model is not None  # it is a part of one that compiled
        robot = self.robots.pop(name)
        self.simulation.forget(robot.prim_path)
        self.stage.remove(robot.prim_path)
        self.simulation.continue_with(model)
