"""The physics of a scene; robots can be added and removed without effect on other bodies.

MuJoCo cannot add bodies to a compiled model. So a new model is compiled from the same scenery, and the state of the bodies that
both models have is copied by name.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass, replace

from graphengine.descriptions.engine import body_names, model_bytes, mujoco
from graphengine.devices.stage import Stage
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files
from graphengine.format.spec import RobotUse
from graphengine.physics.model.fleet_expansion import RobotPlacement, place
from graphengine.physics.model.robot import RobotInstance
from graphengine.physics.model.robot_prims import add_robot
from graphengine.physics.model.scenery import Scenery
from graphengine.physics.simulation import Simulation


@dataclass(frozen=True, slots=True)
class LoadedWorld:
    """A compiled scene.

    Attributes:
        simulation: physics and sensors; implements `devices.backend.World`.
        robots: a dict from name to robot; first the robots of the scene file in order, then the added robots in order.
        scenery: editable models from which any set of robots can be compiled.
    """

    simulation: Simulation
    robots: dict[str, RobotInstance]
    scenery: Scenery

    def __post_init__(self) -> None:
        self.simulation.recompile = self._with_surfaces

    def _with_surfaces(self, bodies: Collection[str]) -> mujoco.MjModel:
        """Return the model of the same robots, with moving surfaces on the named bodies.

        Raises:
            CheckError: MuJoCo refuses the model.
        """
        findings = Findings()
        model = self.scenery.compile(self.robots, findings, bodies)
        findings.raise_errors()
        assert model is not None
        return model

    @property
    def stage(self) -> Stage:
        """Prims of robots and of the world, without graphs."""
        return self.simulation.stage

    def copy(self, files: Files, seed: int) -> LoadedWorld:
        """Return an independent copy of this world. Call this before the first step only.

        Args:
            files: files that the descriptions of added robots may refer to.
            seed: seed of the sensors' noise.
        """
        return LoadedWorld(self.simulation.copy(seed), dict(self.robots), self.scenery.copy(files))

    def begins_as(self, other: LoadedWorld) -> bool:
        """Return whether another world, possibly read from other files, has the same initial state."""
        return list(self.robots) == list(other.robots) and self.simulation.begins_as(other.simulation)

    def reread(self, fresh: LoadedWorld, files: Files) -> LoadedWorld | None:
        """Return a world that continues this simulation with robots that were read again from changed files.

        Args:
            fresh: world with the same initial state as this one, read from the changed files.
            files: files that the descriptions of spawned robots may refer to.

        Returns:
            The world; None if the description of a spawned robot now gives a different model or different prims.

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
        """Return whether another scenery with the given robots compiles to the same model and prims as this world."""
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
        """Add a robot at the pose in `use`, at rest. After an error, nothing has changed.

        Raises:
            CheckError: the robot has errors; the exception lists all errors.
            PhysicsError: MuJoCo cannot simulate the robot at this pose.
            UsageError: the requested ray casting method cannot be used with the robot.
        """
        self.put(self._placement(name, use))
        self.stage.find(self.robots[name].prim_path).facts["spawned"] = True

    def put(self, placement: RobotPlacement) -> None:
        """Add a robot at a known placement, for example that of a robot in a checkpoint; raise the same errors as `add`."""
        findings = Findings()
        self.scenery.forget(self.robots)
        robot = self.scenery.robot(placement, findings)
        findings.raise_errors()
        assert robot is not None
        surfaces = self.simulation.surfaces.velocities
        model = self.scenery.compile({**self.robots, robot.name: robot}, findings, surfaces)
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
        """Return the placement of a robot to add; raise CheckError if its name is invalid, or its name or path is taken."""
        findings = Findings()
        placement, *others = place(name, use)
        if others or placement.name != name:
            findings.add("G109", f"{name!r} is a fleet; add its robots one by one")
        elif not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name):
            findings.add("G109", f"{name!r} is not a valid name: use letters, digits and '_', but no leading digit")
        elif name in {one.name for one in self.simulation.entities.all()}:
            findings.add("S105", f"the name {name!r} is taken by another robot or object; choose another name")
        elif (taken := self.stage.obstacle(placement.prim_path)) is not None:
            text = f"the path {placement.prim_path} of {name!r} is taken: {taken.path} is a {taken.kind}"
            findings.add("S105", text)
        findings.raise_errors()
        return replace(placement, key="")

    def remove(self, name: str) -> None:
        """Remove a robot. Handles to it become invalid."""
        others = {other: robot for other, robot in self.robots.items() if other != name}
        model = self.scenery.compile(others, Findings(), self.simulation.surfaces.velocities)
        assert model is not None  # it is a part of one that compiled
        robot = self.robots.pop(name)
        self.simulation.forget(robot.prim_path)
        self.stage.remove(robot.prim_path)
        self.simulation.continue_with(model)
