"""Set points, gravity compensation and force limits of all drives: the kernel does what numpy does, to the last bit."""

from __future__ import annotations

import dataclasses
import sys
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from graphengine.descriptions.actuators.drives import Drive, servos
from graphengine.descriptions.engine import mujoco
from graphengine.physics.dynamics import drive_step
from graphengine.physics.dynamics.drive_step import DriveStep
from graphengine.physics.dynamics.force_limits import ForceLimits
from graphengine.physics.dynamics.gravity_compensation import GravityCompensation
from graphengine.physics.dynamics.set_points import SetPoints
from graphengine.physics.simulation import Simulation
from tests.physics.harness import Project

Drives = list[tuple[str, Drive]]


@dataclasses.dataclass
class Drivetrain:
    """The parts that a physics step prepares, for one model with its state."""

    model: mujoco.MjModel
    data: mujoco.MjData
    points: SetPoints
    limits: ForceLimits
    step: DriveStep

    def sums(self) -> list[bytes]:
        """Everything that a step changes; the sign of zeros does not matter to MuJoCo, and the processor chooses it."""
        numbers = self.data.ctrl, self.data.qfrc_applied, self.limits.reach, self.data.qpos, self.data.qvel
        return [(part + 0.0).tobytes() for part in numbers] + [bytes([self.points.pending])]


def tree(random: np.random.Generator, bodies: int) -> tuple[str, Drives]:
    """A tree of bodies with joints of both kinds, drives on most of them, and shapes that collide."""
    parents = [int(random.integers(max(0, number - 3), number + 1)) for number in range(bodies)]  # 0 is the world
    drives: Drives = []

    def body(number: int) -> str:
        x, y, z = random.uniform(-0.3, 0.3, 3)
        inside = ""
        if random.random() < 0.8:
            chosen = [
                float(random.choice(gains)) for gains in ((0.0, 40.0, 3e4), (1.0, 90.0, 1e4), (0.5, 20.0, np.inf))
            ]
            speed, pull = random.choice([np.inf, 0.7], 2)
            drive = Drive(chosen[0], chosen[1], 0.3, pull, speed, chosen[2], float(random.choice([0.0, 0.01])))
            even, carries = random.random(2) < 0.5
            drive = dataclasses.replace(drive, interpolate=bool(even), gravity_compensation=bool(carries))
            drives.append((f"j{number}", drive))
            kind, axis = random.choice(["hinge", "slide"]), " ".join(map(str, random.normal(size=3)))
            spring = f'stiffness="{drive.stiffness}" damping="{drive.damping}"'
            inside = f'<joint name="j{number}" type="{kind}" axis="{axis}" {spring}/>'
        weightless = ' gravcomp="0.7"' if random.random() < 0.2 else ""
        below = "".join(body(child + 1) for child in range(bodies) if parents[child] == number and child + 1 > number)
        geom = f'<geom size="0.05" pos="{z} {x} {y}" mass="{random.uniform(0.1, 5.0)}"/>'
        return f'<body pos="{x} {y} {z}"{weightless}>{inside}{geom}{below}</body>'

    trees = "".join(body(child + 1) for child in range(bodies) if parents[child] == 0)
    gains = [(name, joint, gain) for joint, drive in drives for name, gain in servos(joint, drive) if gain > 0]
    actuators = "".join(f'<general name="{name}" joint="{joint}" gainprm="{gain}"/>' for name, joint, gain in gains)
    return f"<worldbody>{trees}</worldbody><actuator>{actuators}</actuator>", drives


def drivetrain(text: str, drives: Drives, *, numba: bool) -> Drivetrain:
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_step1(model, data)
    parts = SetPoints(model, data, drives), ForceLimits(model, data, drives), GravityCompensation(model, data, drives)
    with pytest.MonkeyPatch.context() as patch:
        if not numba:
            patch.setattr(drive_step, "_kernel", lambda: None)
        step = DriveStep(model, data, *parts)
    return Drivetrain(model, data, parts[0], parts[1], step)


def moves(train: Drivetrain, seed: int, steps: int) -> list[list[bytes]]:
    """What some steps lead to while commands, applied forces and gravity change."""
    random, found = np.random.default_rng(seed), []
    for number in range(steps):
        if random.random() < 0.5:
            train.points.targets[:] = random.normal(size=train.model.nu)
            train.points.efforts[:] = random.choice([0.0, 1.0, -30.0], train.model.nv)
            train.points.pending = True
        train.step.prepare(4 - number % 4)
        found.append(train.sums())
        mujoco.mj_step2(train.model, train.data)
        mujoco.mj_step1(train.model, train.data)
    return found


@settings(max_examples=40)
@given(st.integers(0, 2**32), st.integers(1, 40), st.sampled_from(["0 0 -9.81", "0.7 -1.1 -9.2", "0 0 0"]))
@example(1, 300, "0 0 -9.81")
@example(2, 150, "3 -4 -5")
def test_the_kernel_prepares_a_step_as_numpy_does_to_the_last_bit(seed: int, bodies: int, gravity: str) -> None:
    pytest.importorskip("numba", exc_type=ImportError)
    random = np.random.default_rng(seed)
    inner, drives = tree(random, bodies)
    text = f'<mujoco><option timestep="0.004" integrator="discrete" gravity="{gravity}"/>{inner}</mujoco>'
    compiled, plain = (drivetrain(text, drives, numba=numba) for numba in (True, False))
    assert moves(compiled, seed, 12) == moves(plain, seed, 12)
    kernel: Any = drive_step._kernel()
    assert len(kernel.signatures) == 1  # a model of another size is no reason to compile again


def test_the_sum_over_links_has_the_order_of_numpy_for_any_number_of_links() -> None:
    pytest.importorskip("numba", exc_type=ImportError)
    from graphengine.physics.dynamics.drive_kernel import add_moments

    random = np.random.default_rng(0)
    masses, places = random.uniform(0.1, 5.0, 700), random.normal(size=(700, 3))
    for count in (*range(1, 40), 127, 128, 129, 136, 137, 255, 256, 257, 300, 513, 699):
        first = 699 - count
        sums = np.add.reduceat(masses[:, None] * places, [first, 699])[0]
        rest = [add_moments(masses, places, axis, first + 1, count - 1) for axis in range(3)]
        assert (masses[first] * places[first] + rest).tolist() == sums.tolist()


def test_drives_give_the_same_motion_without_numba(project: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    def driven() -> tuple[Simulation, bytes]:
        drive = "{stiffness: 50, damping: 5, max_force: 3, interpolate: true, gravity_compensation: true}"
        simulation, joints = project.robot(f"joints: {{arm_joint: {{drive: {drive}}}}}").load_joints()
        for tick in range(10):
            joints.select().command(positions=[0.1 * tick])
            for _ in range(4):
                simulation.step()
        return simulation, bytes(simulation.data.qpos.tobytes())

    drive_step._kernel.cache_clear()
    with_numba = driven()[1]
    monkeypatch.setitem(sys.modules, "numba", None)
    drive_step._kernel.cache_clear()
    try:
        assert drive_step._kernel() is None
        assert driven()[1] == with_numba
    finally:
        drive_step._kernel.cache_clear()
