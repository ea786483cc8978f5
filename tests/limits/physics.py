"""Limits of the room physics on worlds, sensors and maps."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from pydantic import ValidationError

from graphengine.descriptions.engine import mujoco
from graphengine.devices.entity import Move, Overlap, warning
from graphengine.format.errors import ContextError, PhysicsError, UsageError
from graphengine.node.context import device_access
from graphengine.physics.dynamics import command_limits
from graphengine.physics.occupancy import occupancy_map
from graphengine.physics.occupancy.grid import Grid
from graphengine.physics.occupancy.occupancy_map import OCCUPIED, MapRequest
from graphengine.physics.ray_casting.fast import rays
from graphengine.physics.sensors.lidar import BeamsSpec
from graphengine.physics.sensors.raycast import RaycastProfile
from tests.bringup.maps.test_localizability import judged, room
from tests.limits.table import accepts, limit
from tests.physics.harness import Project


@limit("devices.camera.LARGEST_PICTURE")
def _(pixels: int) -> bool:
    return accepts(lambda: device_access._expect_size(1, pixels), ContextError)


@limit("devices.entity.MOST_TOLD")
def _(overlaps: int) -> bool:
    return "more" not in warning("bot", [Overlap("wall", 0.1)] * overlaps)


@limit("physics.loading.SLOWEST", lower=True)
def _(rate: float, folder: Path) -> bool:
    return "tick_rate" not in str(Project(folder).scene(f"physics: {{tick_rate: {rate!r}}}\n").errors())


@limit("physics.dynamics.command_limits.FASTEST_WHEEL")
def _(speed: float) -> bool:
    """The commanded speed of a wheel whose robot file has no limit."""
    wheel = SimpleNamespace(kind="joint", facts={"joint": "wheel", "effort": 1.0})
    robot = SimpleNamespace(facts={"joints": ["wheel"], "wheel_radii": {"wheel": 0.1}}, descendants=lambda: [wheel])
    arrays = {key: [0] for key in ("body_rootid", "jnt_bodyid", "jnt_dofadr", "jnt_limited")}
    model = SimpleNamespace(**arrays, body_subtreemass=[1.0], dof_M0=[1.0])
    ((slowest, fastest),) = command_limits.command_limits(model, robot, [0])["velocity"]  # type: ignore[arg-type]
    return slowest <= -speed and speed <= fastest


@limit("physics.handles.conveyors.FASTEST")
def _(speed: float, folder: Path) -> bool:
    simulation = Project(folder).world('<body name="belt"><geom size="1 1 1" type="box"/></body>').load().simulation
    belt = simulation.conveyor(simulation.stage.find("/World/belt"))
    return accepts(lambda: belt.move((speed, 0.0, 0.0), (0.0, -speed, 0.0)), PhysicsError)


@limit("physics.handles.mujoco_entities.MOST")
def _(metres: float, folder: Path) -> bool:
    entities = Project(folder).load().simulation.entities
    return accepts(lambda: entities.place("bot", Move(position=(metres, 0.0, 0.0))), UsageError)


@limit("physics.sensors.raycast.MAX_RAYS")
def _(rays: int) -> bool:
    return accepts(lambda: RaycastProfile(ray_directions=[(1.0, 0.0, 0.0)] * rays), ValidationError)  # type: ignore[arg-type]


@limit("physics.sensors.lidar.MAX_BEAMS")
def _(beams: int) -> bool:
    return accepts(lambda: BeamsSpec(first_deg=0, last_deg=1, count=beams), ValidationError)


@limit("physics.occupancy.occupancy_map.FARTHEST")
def _(metres: float) -> bool:
    return accepts(lambda: MapRequest((0.0, 1.0), 0.1, seeds=[(metres, 0.0)]), UsageError)


@limit("physics.occupancy.occupancy_map.SMALLEST_CELL", lower=True)
def _(metres: float) -> bool:
    return accepts(lambda: MapRequest((0.0, 1.0), metres), UsageError)


@limit("physics.occupancy.occupancy_map.MOST_CELLS")
def _(cells: int) -> bool:
    grid = Grid.around((0.0, 0.0), (float(cells), 1.0), 1.0, (0.0, 0.0))
    return accepts(lambda: occupancy_map._check_size(grid), UsageError)


@limit("bringup.maps.localizability.LARGEST_CELL")
def _(metres: float) -> bool:
    """The map has no free place, which is refused next."""
    chart = room(1.0, 1.0)
    full = replace(chart, grid=replace(chart.grid, cell=metres), cells=np.full_like(chart.cells, OCCUPIED))
    with pytest.raises(UsageError) as caught:
        judged(full)
    return "no free place" in str(caught.value)


@limit("bringup.maps.localizability.MOST_PLACES", at=2)
def _(places: int) -> bool:
    """A corridor with one row of places, which are half a metre apart."""
    return accepts(lambda: judged(room(1.0 + 0.5 * (places - 1), 1.0)), UsageError)


@limit("physics.ray_casting.fast.rays.MAX_TRIANGLES", at=10)
def _(triangles: int) -> bool:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rays, "count_triangles", lambda model, visible: triangles)
        return not rays.why_not(mujoco.MjModel.from_xml_string("<mujoco/>"))
