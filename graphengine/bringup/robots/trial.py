"""Compiles the draft of a robot file as a MuJoCo model, for modules that measure the robot."""

from __future__ import annotations

from graphengine.descriptions.description_reader import robot_file
from graphengine.descriptions.engine import REFUSALS, compiled, mujoco
from graphengine.descriptions.files.references import Library
from graphengine.descriptions.robot_files.draft import Draft
from graphengine.format.diagnostics import Findings
from graphengine.format.document import Document
from graphengine.format.spec import RobotUse
from graphengine.physics.model.fleet_expansion import place
from graphengine.physics.model.robot import RobotInstance, load_robot
from graphengine.physics.model.robot_model import robot_spec

FLOOR_FRICTION = 1.0
"""Friction coefficient of the floor on which an imported robot is simulated."""


def trial_spec(draft: Draft) -> tuple[mujoco.MjSpec, RobotInstance] | None:
    """Return the robot of a draft; None if the draft has errors or no library.

    The errors are discarded, because the import reports them later.
    """
    if draft.library is None:
        return None
    reported, draft.library.findings = draft.library.findings, Findings()
    try:
        return checked_spec(draft, draft.library, f"{draft.name}.yaml")
    finally:
        draft.library.findings = reported


def checked_spec(
    draft: Draft, library: Library, use: str, document: Document | None = None
) -> tuple[mujoco.MjSpec, RobotInstance] | None:
    """Return the robot of a draft; after an error, add it to the findings of the library and return None.

    Args:
        draft: draft of the robot file.
        library: reads the meshes.
        use: path of the robot file.
        document: the robot file, whose positions findings contain.
    """
    file = robot_file(draft, library.findings, document)
    (placement,) = place(draft.name, RobotUse(use=use))
    robot = load_robot(placement, file, library, draft.description) if file is not None else None
    spec = robot_spec(robot, library, FLOOR_FRICTION, library.findings) if robot is not None else None
    return (spec, robot) if spec is not None and robot is not None else None


def trial(draft: Draft) -> mujoco.MjModel | None:
    """Return the compiled model of a draft's robot; None if the draft has errors or MuJoCo refuses the model."""
    found = trial_spec(draft)
    return trial_model(draft, found[0]) if found is not None else None


def trial_model(draft: Draft, spec: mujoco.MjSpec) -> mujoco.MjModel | None:
    """Return the compiled model; None if MuJoCo refuses to compile it.

    The draft keeps the warnings, because MuJoCo warns about a mesh file only when it first decodes the file.
    """
    try:
        model, warnings = compiled(spec)
    except REFUSALS:
        return None
    draft.mujoco_warnings.update(dict.fromkeys(warnings))
    return model
