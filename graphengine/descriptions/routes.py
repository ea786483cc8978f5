"""The routes of movers: points with times, and the texts that store them in a MuJoCo model.

A route in the model itself stays with the mover when the model is copied, compiled again or compared.
"""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass

from graphengine.descriptions.engine import mujoco
from graphengine.format.scene_spec import MoverSpec

PREFIX = ":mover:"
"""Prefix of the names of custom texts that hold routes of movers in a model; no robot's name has a colon."""


@dataclass(frozen=True, slots=True)
class Route:
    """The route of a mover.

    Attributes:
        start: time at which the mover starts, s.
        points: time since the start (s) and position (x, y, z, m) of each point, in ascending order of the times.
        period: time after which the route begins again, s; 0 if the mover stays at the last point.
        region: corners of the rectangle in which the mover walks at random, or None. With a rectangle, `points` is only the place
            of the mover if no point of the rectangle is free.
        speed: speed of a random walk, m/s.
    """

    start: float
    points: tuple[tuple[float, float, float, float], ...]
    period: float = 0.0
    region: tuple[tuple[float, float], tuple[float, float]] | None = None
    speed: float = 0.0

    @property
    def rises(self) -> bool:
        """Whether the points of the route have different heights."""
        return len({height for *_, height in self.points}) > 1

    def text(self) -> str:
        """Return the text from which `routes_of` reads this route."""
        return json.dumps(asdict(self))


def route_of(mover: MoverSpec) -> Route:
    """Return the route of a mover of a scene."""
    if mover.region is not None:
        (x, y), (u, v) = mover.region
        corners = (min(x, u), min(y, v)), (max(x, u), max(y, v))
        return Route(mover.start, ((0.0, (x + u) / 2.0, (y + v) / 2.0, 0.0),), region=corners, speed=mover.speed)
    assert mover.path is not None
    stops = list(mover.path)
    if mover.loop == "there_and_back":
        stops += stops[-2::-1]
    elif mover.loop:
        stops.append(stops[0])
    if mover.loop:
        stops[-1] = stops[-1].model_copy(update={"pause": 0.0})
    time, points, before = 0.0, list[tuple[float, float, float, float]](), stops[0].at
    for stop in stops:
        time += math.dist(before, stop.at) / mover.speed
        points.append((time, *stop.at))
        if stop.pause:
            time += stop.pause
            points.append((time, *stop.at))
        before = stop.at
    return Route(mover.start, tuple(points), time if mover.loop else 0.0)


def routes_of(model: mujoco.MjModel | mujoco.MjSpec) -> dict[str, str]:
    """Return the texts of all routes in a model, by the names of the movers."""
    if isinstance(model, mujoco.MjSpec):
        texts = [(text.name, text.data) for text in model.texts]
    else:
        names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_TEXT, index) for index in range(model.ntext)]
        texts = list(zip(names, bytes(model.text_data).decode().split("\0"), strict=False))  # each ends with a zero
    return {name.removeprefix(PREFIX): text for name, text in texts if name.startswith(PREFIX)}


def route_from(text: str) -> Route:
    """Return the route that `Route.text` wrote."""
    values = json.loads(text)
    region = tuple(map(tuple, values["region"])) if values["region"] is not None else None
    return Route(**{**values, "points": tuple(map(tuple, values["points"])), "region": region})
