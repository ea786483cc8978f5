"""The confined process in which USD reads the physics of one stage: it reads a request from stdin and answers on stdout.

USD's readers are native code that reads an untrusted file. Therefore the process is limited and confined, and a crash of the
reader ends only this process.
"""

from __future__ import annotations

from typing import Any

from pxr import Tf, Usd, UsdPhysics

from graphengine.descriptions.usd.confined_reading import ConfinedReading, prims
from graphengine.descriptions.usd.layers import UnreadableError, variants_of
from graphengine.descriptions.usd.stage_bodies import body_of, is_body, read_body
from graphengine.descriptions.usd.stage_commands import read_command
from graphengine.descriptions.usd.stage_frames import StageFrames, UnusableError, given, text
from graphengine.descriptions.usd.stage_joints import is_joint, read_joint
from graphengine.descriptions.usd.stage_lights import read_gravity, read_light
from graphengine.descriptions.usd.stage_materials import read_material
from graphengine.descriptions.usd.stage_sensors import read_sensor
from graphengine.descriptions.usd.stage_shapes import ShapeReader
from graphengine.descriptions.usd_model import PhysicsContents
from graphengine.format.files import Files

MAX_PRIMS = 200_000
"""Maximum number of prims of a stage whose physics is read."""


class PhysicsReading(ConfinedReading[PhysicsContents]):
    """Reader of the physics of one stage."""

    def __init__(self, files: Files, **choice: Any) -> None:
        super().__init__(files, **choice)
        self.contents = PhysicsContents()

    def read(self, stage: Usd.Stage) -> None:
        """Read bodies, shapes, joints, materials, commands, sensors and lights.

        Raises:
            UnreadableError: the stage has too many prims, or a number of its units is not finite.
        """
        try:
            frames = StageFrames(stage)
        except UnusableError as error:
            raise UnreadableError(str(error)) from None
        self.contents.assumed = frames.assumed
        shapes = ShapeReader(frames, self.contents)
        for number, prim in enumerate(prims(stage), 1):
            if number > MAX_PRIMS:
                raise UnreadableError(f"it has more than {MAX_PRIMS} prims")
            self._one(prim, frames, shapes)

    def _one(self, prim: Usd.Prim, frames: StageFrames, shapes: ShapeReader) -> None:
        """Read one prim; a body comes before the prims below it."""
        contents, path = self.contents, str(prim.GetPath())
        try:
            if is_body(prim):
                contents.bodies[path] = read_body(prim, frames)
            variants_of(prim, contents.choices)
            for shape in shapes.read(prim):
                owner = contents.bodies.get(body_of(prim))
                (owner.shapes if owner is not None else contents.shapes).append(shape)
            if is_joint(prim):
                contents.joints[path] = read_joint(prim, frames)
            if (
                prim.HasAPI(UsdPhysics.ArticulationRootAPI)
                and given(prim, "physxArticulation:articulationEnabled") is not False
            ):
                collide = given(prim, "physxArticulation:enabledSelfCollisions")
                contents.roots[path] = collide is True
            if prim.HasAPI(UsdPhysics.MaterialAPI):
                contents.materials[path] = read_material(prim)
            if (command := read_command(prim)) is not None:
                contents.commands.append(command)
            if (sensor := read_sensor(prim, frames)) is not None:
                contents.sensors.append(sensor)
            if (light := read_light(prim, frames)) is not None:
                contents.lights.append(light)
            contents.gravity = contents.gravity or read_gravity(prim, frames)
            for name, texts in (("isaac:namespace", contents.namespaces), ("isaac:nameOverride", contents.names)):
                if value := text(prim, name):
                    texts[path] = value
        except (UnusableError, Tf.ErrorException, TypeError, ValueError, AttributeError, OverflowError) as error:
            why = str(error) if isinstance(error, UnusableError) else "it has values of illegal types"
            contents.left_out.append((path, why))


if __name__ == "__main__":
    PhysicsReading.serve()
