"""Write the worlds of `scenes/worlds`: flat_grid, table, simple_warehouse, full_warehouse and warehouse_features.

    python -m tests.physics.make_worlds

Everything is a box, a cylinder or the floor, so that lidars, occupancy maps and a laptop's
renderer are exact and quick. A world holds no robot and no actuator. One object is one body and
its parts are geoms named `<body>/<part>`: as prims, /World/rack_03/load_2. Cartons (`box_01`, ...),
cones and empty barrels have a free joint and can be pushed about; until they are, they sleep.

One rule holds for all static obstacles: what is wider than 0.3 m crosses both the plane of the
lidar (z = 0.165 m) and the band that an occupancy map looks at (z = 0.175 to 0.675 m). A robot
never meets what its lidar or its map cannot see.

The things of simple_warehouse have prints, which cameras see (`world_prints.py`).

Units are metres, kilograms and degrees. The output depends on nothing but this file.
"""

from __future__ import annotations

import math
import random
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Sequence
from pathlib import Path

from tests.physics.world_prints import PRINTS, faces, write_prints

SHIPPED = Path(__file__).resolve().parents[2] / "scenes/worlds"

Rectangle = tuple[tuple[float, float], tuple[float, float]]  # ((west, east), (south, north))

WALL = 5.2  # height of walls and columns
BAY = 4.05  # from upright to upright along a rack
RACK_DEPTH = 1.10
PALLET = 0.144  # height of an empty pallet

SLIDING = {"friction": "0.5 0.005 0.0001", "priority": "1"}  # this counts, whatever the floor has

COLOURS = {
    "wall": "0.86 0.87 0.88",
    "wall_band": "0.42 0.50 0.58",
    "column": "0.70 0.72 0.74",
    "shutter": "0.60 0.63 0.66",
    "yellow": "0.97 0.77 0.08",
    "rack_post": "0.13 0.28 0.56",
    "rack_beam": "0.80 0.40 0.14",
    "wood": "0.70 0.53 0.34",
    "carton_light": "0.83 0.69 0.49",
    "carton": "0.74 0.58 0.38",
    "carton_dark": "0.63 0.47 0.29",
    "wrap": "0.80 0.84 0.87",
    "crate": "0.25 0.48 0.44",
    "dark": "0.15 0.16 0.18",
    "steel": "0.45 0.47 0.50",
    "orange": "0.96 0.36 0.06",
    "white": "0.95 0.95 0.94",
    "barrel": "0.10 0.32 0.62",
}
LOADS = ("carton", "carton_light", "wrap", "carton_dark", "carton", "carton_light", "crate")

CONCRETE = {"builtin": "flat", "rgb1": "0.58 0.59 0.60", "mark": "edge", "markrgb": "0.46 0.47 0.48"}
GRID = {
    "builtin": "checker",
    "rgb1": "0.36 0.39 0.43",
    "rgb2": "0.41 0.44 0.48",
    "mark": "edge",
    "markrgb": "0.66 0.69 0.72",
}


def text(*values: float) -> str:
    """The numbers of one attribute, rounded: the last bits of a sine never reach the file."""
    return " ".join(f"{round(value, 5) + 0.0:g}" for value in values)


def add(parent: ET.Element, tag: str, **attributes: str) -> ET.Element:
    """Append an element and return it."""
    return ET.SubElement(parent, tag, attributes)


class Body:
    """One object. A part is placed in the object's frame, by the middle of its underside."""

    def __init__(self, element: ET.Element) -> None:
        self.element = element
        self.name = element.attrib["name"]

    def box(
        self, part: str, material: str, size: Sequence[float], at: Sequence[float] = (0, 0, 0), **more: str
    ) -> None:
        """A box of `size` (length, width, height)."""
        half = text(*(side / 2 for side in size))
        middle = text(at[0], at[1], at[2] + size[2] / 2)
        self._geom(part, material, type="box", size=half, pos=middle, **more)

    def cylinder(self, part: str, material: str, radius: float, height: float, base: float = 0, **more: str) -> None:
        """An upright cylinder that begins at a height of `base`."""
        middle = text(0, 0, base + height / 2)
        self._geom(part, material, type="cylinder", size=text(radius, height / 2), pos=middle, **more)

    def axle(self, part: str, radius: float, length: float, x: float) -> None:
        """A pair of wheels: one cylinder that lies across the object, along y."""
        size, middle = text(radius, length / 2), text(x, 0, radius)
        self._geom(part, "dark", type="cylinder", size=size, pos=middle, zaxis="0 1 0")

    def _geom(self, part: str, material: str, **attributes: str) -> None:
        add(self.element, "geom", name=f"{self.name}/{part}", material=material, **attributes)


class World:
    """An MJCF document with the options, the lights and the materials that all worlds share."""

    def __init__(
        self, name: str, floor: dict[str, str], tile: float, inside: Rectangle | None = None, *, printed: bool = False
    ) -> None:
        """`floor` is the texture of one tile; without `inside` the floor is endless; `printed` things have prints."""
        self.name = name
        self.printed = printed
        self.root = ET.Element("mujoco", model=name)
        add(self.root, "compiler", angle="radian", autolimits="true")
        # What a scene sets by default. A scene's own timestep wins.
        solver = {"integrator": "discrete", "cone": "elliptic", "solver": "Newton"}
        self.option = add(self.root, "option", timestep=repr(1 / 240), **solver)
        # With extent 1, znear and zfar are metres; else MuJoCo scales them by the scene's size.
        add(self.root, "statistic", extent="1", center="0 0 0.5", meansize="0.2")
        visual = add(self.root, "visual")
        add(visual, "map", znear="0.02", zfar="120")
        # Lights come from afar, so a side of a box is of one brightness: to draw it in 16 parts takes half as long again.
        add(visual, "quality", offsamples="0", numquads="1")
        add(visual, "global", offwidth="1280", offheight="800")
        add(visual, "headlight", ambient=grey(0.41), diffuse=grey(0.22), specular=grey(0))
        add(visual, "rgba", haze="0.72 0.77 0.82 1")

        self.assets = add(self.root, "asset")
        sky = {"builtin": "gradient", "rgb1": "0.87 0.90 0.93", "rgb2": "0.60 0.66 0.73"}
        add(self.assets, "texture", name="sky", type="skybox", width="64", height="384", **sky)
        add(self.assets, "texture", name="floor", type="2d", width="512", height="512", **floor)
        repeat = text(2 / tile, 2 / tile)  # MuJoCo counts in half sizes
        self._material("floor", texture="floor", texuniform="true", texrepeat=repeat, reflectance="0.04")

        self.worldbody = add(self.root, "worldbody")
        self._light("sun", "0.25 0.2 -0.95", 0.4, shadow=True)
        self._light("fill", "-0.7 -0.4 -0.45", 0.25)
        (west, east), (south, north) = inside or ((0, 0), (0, 0))
        pose = {"pos": text((west + east) / 2, (south + north) / 2, 0)}
        size = text((east - west) / 2, (north - south) / 2, 1)
        look = {"material": "floor", "friction": "0.8 0.005 0.0001"}
        add(self.worldbody, "geom", name="floor", type="plane", size=size, **pose, **look)

    def _material(self, name: str, **attributes: str) -> None:
        add(self.assets, "material", name=name, specular="0.1", shininess="0.1", **attributes)

    def _light(self, name: str, direction: str, diffuse: float, *, shadow: bool = False) -> None:
        colour = {"diffuse": grey(diffuse), "specular": grey(0), "castshadow": str(shadow).lower()}
        pose = {"type": "directional", "pos": "0 0 10", "dir": direction}
        add(self.worldbody, "light", name=name, **pose, **colour)

    def plan(self, x: float, y: float, extent: float) -> None:
        """A camera for the floor plan: `extent` metres from its lower to its upper edge, +x up."""
        view = {"projection": "orthographic", "fovy": text(extent), "resolution": "1280 800"}
        add(self.worldbody, "camera", name="top", pos=text(x, y, 30), xyaxes="0 -1 0 1 0 0", **view)

    def camera(self, name: str, pos: Sequence[float], look_at: Sequence[float], fovy: float) -> None:
        """An upright camera for pictures."""
        x, y, z = (p - q for p, q in zip(pos, look_at, strict=True))
        axes = text(-y, x, 0, -x * z, -y * z, x * x + y * y)
        view = {"xyaxes": axes, "fovy": text(fovy), "resolution": "1280 800"}
        add(self.worldbody, "camera", name=name, pos=text(*pos), **view)

    def body(self, name: str, x: float = 0, y: float = 0, yaw: float = 0, *, z: float = 0, loose: bool = False) -> Body:
        """An object on the floor or at a height, as yet without parts. A loose one can be pushed, and sleeps until it is."""
        element = add(self.worldbody, "body", name=name, pos=text(x, y, z))
        if loose:
            add(element, "freejoint", name=name)
            element.set("sleep", "init")
            if self.option.find("flag") is None:
                add(self.option, "flag", sleep="enable")
        if yaw:
            half = math.radians(yaw) / 2
            element.set("quat", text(math.cos(half), 0, 0, math.sin(half)))
        return Body(element)

    def write(self, folder: Path) -> None:
        """Add the materials in use and write the file."""
        used = {geom.get("material") for geom in self.root.iter("geom")}
        for name, rgb in COLOURS.items():
            if name in used:
                self._material(name, rgba=f"{rgb} 1", **self._print(name))
        ET.indent(self.root)
        document = ET.tostring(self.root, encoding="unicode")
        head = "<!-- Written by make_worlds.py: change that file, not this one. -->"
        path = folder / f"{self.name}.xml"
        path.write_text(f"{head}\n{document}\n", encoding="utf-8", newline="\n")

    def _print(self, material: str) -> dict[str, str]:
        """Add the texture with the print of a material, if it has one; return the attribute that refers to it."""
        if not self.printed or material not in PRINTS:
            return {}
        name = PRINTS[material].__name__
        if not any(texture.get("name") == name for texture in self.assets.iter("texture")):
            add(self.assets, "texture", name=name, type="cube", **faces(material))
        return {"texture": name}


def grey(value: float) -> str:
    """A colour with equal parts."""
    return text(value, value, value)


def numbered(kind: str, rows: Iterable[Sequence[float]]) -> Iterable[tuple[str, Sequence[float]]]:
    """Names for a table of objects: kind_01, kind_02, ..."""
    return ((f"{kind}_{index:02}", row) for index, row in enumerate(rows, start=1))


def walls(world: World, inside: Rectangle) -> None:
    """Four walls around the inner rectangle, painted darker up to 1.2 m."""
    (west, east), (south, north) = inside
    thick, band = 0.2, 1.2
    middle = (west + east) / 2, (south + north) / 2
    along_x, along_y = (east - west + 2 * thick, thick), (thick, north - south)
    body = world.body("walls")
    for side, x, y, size in (
        ("south", middle[0], south - thick / 2, along_x),
        ("north", middle[0], north + thick / 2, along_x),
        ("west", west - thick / 2, middle[1], along_y),
        ("east", east + thick / 2, middle[1], along_y),
    ):
        body.box(f"{side}_base", "wall_band", (*size, band), (x, y, 0))
        body.box(side, "wall", (*size, WALL - band), (x, y, band))


def columns(world: World, xs: Sequence[float], ys: Sequence[float], side: float) -> None:
    """Square columns with a yellow guard around the foot."""
    for name, (x, y) in numbered("column", [(x, y) for x in xs for y in ys]):
        body = world.body(name, x, y)
        body.box("shaft", "column", (side, side, WALL - 0.05))
        body.box("guard", "yellow", (side + 0.03, side + 0.03, 1.0))


def rack(
    world: World,
    name: str,
    origin: tuple[float, float],
    bays: int,
    dice: random.Random,
    *,
    guarded: Sequence[int],
    uneven: bool = False,
) -> None:
    """A row of pallet racking, from its first upright at `origin` along +y.

    Loaded pallets fill the floor of every bay. `guarded` uprights have a yellow guard. In an uneven row the loads on the
    floor are of different depth, or missing.
    """
    post, length = 0.10, bays * BAY
    row = world.body(name, origin[0], origin[1] + length / 2)
    for upright in range(bays + 1):
        y = upright * BAY - length / 2
        for side, x in (("west", post - RACK_DEPTH), ("east", RACK_DEPTH - post)):
            row.box(f"post_{upright}_{side}", "rack_post", (post, post, 5.0), (x / 2, y, 0))
        if upright in guarded:
            row.box(f"guard_{upright}", "yellow", (1.40, 0.30, 0.70), (0, y, 0))
    shelves = (1.6, 3.1, 4.6)
    for level, top in enumerate(shelves, start=1):
        size = (RACK_DEPTH - 0.02, length - post, 0.12)
        row.box(f"shelf_{level}", "rack_beam", size, (0, 0, top - 0.12))
    count = 0
    for bay in range(bays):
        middle = (bay + 0.5) * BAY - length / 2
        if not uneven:
            row.box(f"pallets_{bay}", "wood", (1.06, 3.6, PALLET), (0, middle, 0))
        for level, base in enumerate((PALLET, *shelves)):
            loads = uneven_loads(dice) if uneven and level == 0 else bay_loads(level, dice)
            for offset, width, *shape in loads:
                depth, shift = shape or (1.0, 0.0)
                if uneven and level == 0:
                    row.box(f"pallet_{count}", "wood", (depth, width, PALLET), (shift, middle + offset, 0))
                size = (depth, width, 0.66 + 0.1 * int(4 * dice.random()))
                material = LOADS[int(len(LOADS) * dice.random())]
                row.box(f"load_{count}", material, size, (shift, middle + offset, base))
                count += 1


def uneven_loads(dice: random.Random) -> list[tuple[float, float, float, float]]:
    """What stands on the floor of a bay, each as (offset along the rack, width, depth, shift across the rack); three at most."""
    loads = []
    for offset in (-1.2, 0.0, 1.2):
        chance, depth, side = dice.random(), 0.6 + 0.1 * int(6 * dice.random()), dice.random() - 0.5
        if chance > 0.3:
            loads.append((offset, 1.0, depth, math.copysign((1.1 - depth) / 2, side)))
    return loads


def bay_loads(level: int, dice: random.Random) -> list[tuple[float, float]]:
    """What stands in a bay, each as (offset along the rack, width). The floor, level 0, is full."""
    left, right, whole = (-0.92, 1.7), (0.92, 1.7), (0.0, 3.5)
    chance = dice.random()
    if level == 0:
        return [left, right] if chance < 0.3 else [whole]
    if chance < 0.2:
        return [whole]
    if chance < 0.35:
        return [left]
    return [right] if chance < 0.5 else []


def pallet(world: World, name: str, at: Sequence[float], height: float, load: str) -> None:
    """A pallet of 1.2 m x 1.0 m at (x, y, yaw) with its load; `height` is that of both."""
    body = world.body(name, *at)
    body.box("pallet", "wood", (1.2, 1.0, PALLET))
    body.box("load", load, (1.16, 0.96, height - PALLET), (0, 0, PALLET))


def forklift(world: World, name: str, x: float, y: float, yaw: float) -> None:
    """A truck of 3.4 m x 1.2 m x 2.1 m. Its forks, along +x, are under a load that a lidar sees."""
    truck = world.body(name, x, y, yaw)
    truck.box("chassis", "yellow", (1.95, 1.14, 0.68), (-0.60, 0, 0.12))
    truck.box("counterweight", "dark", (0.55, 1.10, 0.95), (-1.42, 0, 0.15))
    truck.box("roof", "dark", (1.30, 1.00, 0.07), (-0.60, 0, 2.03))
    for side, across in (("left", 0.44), ("right", -0.44)):
        truck.box(f"pillar_{side}", "dark", (0.07, 0.07, 1.03), (-1.2, across, 1.0))
        truck.box(f"mast_{side}", "steel", (0.16, 0.12, 2.06), (0.46, across, 0.04))
    truck.box("carriage", "dark", (0.08, 0.95, 0.60), (0.58, 0, 0.10))
    truck.axle("front_wheels", 0.30, 1.20, 0.10)
    truck.axle("rear_wheels", 0.25, 1.16, -1.20)
    truck.box("pallet", "wood", (1.05, 1.2, PALLET), (1.175, 0, 0))
    truck.box("load", "wrap", (1.02, 1.14, 0.9), (1.175, 0, PALLET))


def charging_station(world: World, name: str, x: float, y: float, yaw: float) -> None:
    """A station of 0.9 m x 0.5 m x 1.2 m with a dock in front of it, between two posts that a robot's lidar tells apart."""
    station = world.body(name, x, y, yaw)
    station.box("cabinet", "white", (0.5, 0.9, 1.2))
    station.box("panel", "dark", (0.02, 0.5, 0.4), (0.26, 0, 0.7))
    station.box("dock", "steel", (0.12, 0.4, 0.3), (0.31, 0, 0))
    for side, across, thick in (("left", 0.62, 0.16), ("right", -0.66, 0.24)):
        station.box(f"post_{side}", "yellow", (thick, thick, 0.9), (0.45, across, 0))


def doorway(world: World, name: str, x: float, y: float, yaw: float, width: float) -> None:
    """A door in a wall behind it, with a frame that stands 0.35 m out of the wall, and a step of light behind it."""
    door = world.body(name, x, y, yaw)
    for side, across in (("left", (width + 0.3) / 2), ("right", -(width + 0.3) / 2)):
        door.box(f"jamb_{side}", "wall_band", (0.35, 0.3, 2.6), (0.175, across, 0))
    door.box("lintel", "wall_band", (0.35, width + 0.6, 0.3), (0.175, 0, 2.6))
    door.box("leaf", "shutter", (0.05, width, 2.6), (0.025, 0, 0))


def cone(world: World, name: str, x: float, y: float) -> None:
    """A loose traffic cone, 0.5 m high and 2.4 kg heavy."""
    body = world.body(name, x, y, loose=True)
    body.box("base", "orange", (0.28, 0.28, 0.03), (0, 0, 0), mass="1.5", **SLIDING)
    body.cylinder("lower", "orange", 0.11, 0.17, 0.03, mass="0.5", **SLIDING)
    body.cylinder("band", "white", 0.08, 0.13, 0.20, mass="0.3", **SLIDING)
    body.cylinder("tip", "orange", 0.05, 0.17, 0.33, mass="0.1", **SLIDING)


def barrel(world: World, name: str, x: float, y: float, *, empty: bool = False) -> None:
    """A barrel of 0.58 m x 0.88 m. An empty one is loose and weighs 9 kg."""
    body = world.body(name, x, y, loose=empty)
    drum, lid = ({"mass": mass, **SLIDING} if empty else {} for mass in ("8", "1"))
    body.cylinder("drum", "barrel", 0.29, 0.86, 0, **drum)
    body.cylinder("lid", "dark", 0.27, 0.02, 0.86, **lid)


def carton(world: World, name: str, at: Sequence[float], side: float, mass: float) -> None:
    """A loose carton at (x, y, yaw)."""
    size = (side, side, 0.8 * side)
    world.body(name, *at, loose=True).box("carton", "carton_light", size, (0, 0, 0), mass=text(mass), **SLIDING)


def flat_grid() -> World:
    """An endless floor in squares of 1 m, with a light line every 2 m."""
    return World("flat_grid", GRID, tile=2)


def table() -> World:
    """A workbench with a place for an arm at the origin, 0.75 m above the floor, and objects within its reach.

    The strip of 0.5 m ahead of the arm is free, since many arms lie along it when all joints are at zero.
    """
    top, slab = 0.75, 0.04
    world = World("table", CONCRETE, 2)
    world.plan(0.4, 0, 2.4)
    world.camera("overview", (2.5, -1.9, 1.95), (0.32, 0.02, 0.85), 40)
    bench = world.body("table", 0.4)
    bench.box("top", "wood", (1.3, 1.5, slab), (0, 0, top - slab))
    bench.box("shelf", "carton_dark", (1.1, 1.3, 0.02), (0, 0, 0.2))
    for part, east, north in (
        ("back_left", -1, 1),
        ("back_right", -1, -1),
        ("front_left", 1, 1),
        ("front_right", 1, -1),
    ):
        bench.box(f"leg_{part}", "steel", (0.07, 0.07, top - slab), (0.57 * east, 0.67 * north, 0))
    for part, at, size in (
        ("back", (-0.57, 0.0), (0.05, 1.27)),
        ("front", (0.57, 0.0), (0.05, 1.27)),
        ("left", (0.0, 0.67), (1.07, 0.05)),
        ("right", (0.0, -0.67), (1.07, 0.05)),
    ):
        bench.box(f"rail_{part}", "steel", (*size, 0.06), (*at, top - slab - 0.06))
    plain = {"contype": "0", "conaffinity": "0"}  # 1 mm thick: seen by cameras, touched by nothing
    bench.box("plate", "steel", (0.28, 0.28, 0.001), (-0.4, 0, top), **plain)
    bench.box("mat", "dark", (0.42, 0.34, 0.001), (0.08, -0.46, top), **plain)

    tote = world.body("tote", 0.45, 0.48, -12, z=top)
    tote.box("bottom", "barrel", (0.4, 0.3, 0.01))
    for part, at, size in (
        ("front", (0.195, 0.0), (0.01, 0.3)),
        ("back", (-0.195, 0.0), (0.01, 0.3)),
        ("left", (0.0, 0.145), (0.38, 0.01)),
        ("right", (0.0, -0.145), (0.38, 0.01)),
    ):
        tote.box(part, "barrel", (*size, 0.12), (*at, 0.01))
    grip = "1 0.005 0.0001"
    for name, (index, x, y, yaw, z) in numbered(
        "cube",
        [
            (0, 0.38, -0.36, 10, top),
            (1, 0.52, -0.38, -20, top),
            (2, 0.43, -0.52, 35, top),
            (3, 0.60, -0.55, 5, top),
            (0, 0.50, 0.50, 25, top + 0.01),
            (3, 0.39, 0.45, -40, top + 0.01),
        ],
    ):
        colour = ("orange", "yellow", "crate", "white")[int(index)]
        world.body(name, x, y, yaw, z=z, loose=True).box("cube", colour, (0.05, 0.05, 0.05), mass="0.1", friction=grip)
    can = world.body("can_01", 0.78, -0.42, z=top, loose=True)
    can.cylinder("can", "white", 0.033, 0.115, mass="0.35", friction=grip)
    box = world.body("box_01", 0.86, 0.44, 20, z=top, loose=True)
    box.box("carton", "carton_light", (0.16, 0.22, 0.14), (0, 0, 0), mass="0.8", **SLIDING)

    paint = world.body("floor_markings")
    for part, at, size in (
        ("left", (0.4, 1.5), (3.0, 0.08)),
        ("right", (0.4, -1.5), (3.0, 0.08)),
        ("front", (1.9, 0.0), (0.08, 3.08)),
        ("back", (-1.1, 0.0), (0.08, 3.08)),
    ):
        paint.box(part, "yellow", (*size, 0.002), (*at, 0), **plain)
    return world


def simple_warehouse() -> World:
    """A hall of 19.7 m x 30.15 m: three rack rows, two aisles, two pallets left standing."""
    inside = (west, east), _ = (-10.30, 9.40), (-12.20, 17.95)
    world = World("simple_warehouse", CONCRETE, 4, inside, printed=True)
    world.plan(-0.45, 2.9, 22)
    world.camera("overview", (6.8, -16, 12), (-1.0, 2.0, 0), 56)
    walls(world, inside)
    columns(world, (west - 0.05, east + 0.05), (-9, -3, 3, 9, 15), side=0.30)
    dice = random.Random(7)
    for name, (x,) in numbered("rack", [(-9.25,), (-0.25,), (8.75,)]):
        rack(world, name, (x, -3.8), 4, dice, guarded=range(5))
    pallet(world, "pallet_01", (-6.1, 13.7, 21), 1.1, "wrap")
    pallet(world, "pallet_02", (4.5, 13.7, -21), 1.1, "carton")
    for name, (x, y, yaw, side, mass) in numbered(
        "box", [(-7.8, -7.6, 15, 0.5, 6), (3.2, -8.4, 40, 0.4, 3), (4.1, -7.9, -10, 0.6, 9)]
    ):
        carton(world, name, (x, y, yaw), side, mass)
    for name, (x, y) in numbered("cone", [(-7.6, -5.4), (-2.4, 15.6), (2.2, -5.6)]):
        cone(world, name, x, y)
    for name, (x, y) in numbered("barrel", [(7.3, -9.6), (-5.4, -9.1)]):
        barrel(world, name, x, y, empty=True)
    return world


def full_warehouse() -> World:
    """A hall of 31.8 m x 54 m: ten rack rows, a main aisle, a loading area in the south.

    Robots start in the main aisle, at (-3, 6) or (-5, 10). A forklift and a pallet block the
    straight way from there to a goal at (-3, 14.5); there is room to pass west of them.
    """
    inside = (west, east), (south, _) = (-26.3, 5.5), (-23.4, 30.6)
    world = World("full_warehouse", CONCRETE, 4, inside)
    world.plan(-10.4, 3.6, 35.5)
    world.camera("overview", (4, -27, 20), (-10.5, 0.5, 0), 52)
    world.camera("aisle", (-3.2, -8.5, 3.2), (-3, 9, 0.4), 62)
    walls(world, inside)
    columns(world, (west + 0.175, east - 0.175), (-18, -9, 0, 9, 18, 27), side=0.35)
    for name, (x,) in numbered("dock_door", [(-22,), (-16,), (-10,), (-4,), (2,)]):
        world.body(name, x, south + 0.03).box("shutter", "shutter", (3.2, 0.06, 2.8))

    dice = random.Random(11)
    xs = (-20.0, -16.0, -12.0, -8.0, 1.5)
    for name, (x, _) in numbered("rack", [(x, 0) for x in xs]):
        rack(world, name, (x, -3.85), 4, dice, guarded=(0, 4))
    for index, x in enumerate(xs, start=len(xs) + 1):
        rack(world, f"rack_{index:02}", (x, 16.05), 3, dice, guarded=(0, 3))

    forklift(world, "forklift_01", -2.1, 10.0, 20)
    forklift(world, "forklift_02", -13.4, -15.0, -68)
    pallets = [
        (-4.6, 12.6, 0, 1.10),
        (-24.6, -2.2, 4, 1.20),
        (-24.5, 4.6, -7, 0.95),
        (-24.7, 11.8, 90, 1.30),
        (-22.6, -20.2, 2, 1.15),
        (-21.0, -20.4, -3, 0.95),
        (-16.6, -20.6, 0, 1.25),
        (-3.6, -20.3, 9, 1.10),
        (2.6, -20.1, 90, 1.30),
        (1.0, -19.9, 86, 1.00),
    ]
    for index, (name, (x, y, yaw, height)) in enumerate(numbered("pallet", pallets)):
        pallet(world, name, (x, y, yaw), height, LOADS[index % len(LOADS)])
    cones = [(-4.7, 8.3), (0.2, 9.2), (0.2, 11.0), (-11.6, -13.4), (-15.0, -17.2)]
    for name, (x, y) in numbered("cone", cones):
        cone(world, name, x, y)
    full = [(4.5, -7.2), (4.6, -7.9), (3.9, -7.6), (4.5, -10.4), (-25.6, 15.2)]
    for index, (name, (x, y)) in enumerate(numbered("barrel", [*full, (-5.9, -2.2), (2.9, -9.4)])):
        barrel(world, name, x, y, empty=index >= len(full))
    cartons = [
        (-6.2, 2.4, 12, 0.5, 6),
        (-0.2, 2.2, -8, 0.6, 10),
        (-5.4, -6.0, 30, 0.4, 2),
        (-1.9, -7.4, 55, 0.5, 5),
        (-0.2, 13.6, 20, 0.4, 3),
        (-6.3, 14.9, -15, 0.6, 8),
    ]
    for name, (x, y, yaw, side, mass) in numbered("box", cartons):
        carton(world, name, (x, y, yaw), side, mass)

    # Paint, 2 mm thick: seen by cameras, touched by nothing.
    paint = world.body("floor_markings")
    for part, x, y, size in (
        ("aisle_west", -6.8, 4.0, (0.1, 52)),
        ("aisle_east", 0.4, 4.0, (0.1, 52)),
        ("dock_north", -10.4, -11.5, (31, 0.1)),
        ("racks_south", -10.4, -5.2, (31, 0.1)),
        ("cross_south", -10.4, 13.1, (31, 0.1)),
        ("cross_north", -10.4, 15.3, (31, 0.1)),
    ):
        paint.box(part, "yellow", (*size, 0.002), (x, y, 0), contype="0", conaffinity="0")
    return world


def warehouse_features() -> World:
    """The hall of full_warehouse with features that a lidar can tell apart, for localization.

    No two bays of the racks are alike, columns stand at irregular distances, pallets of different size at the ends of racks,
    and doors and a charging station along the walls.
    """
    inside = (west, east), (south, north) = (-26.3, 5.5), (-23.4, 30.6)
    world = World("warehouse_features", CONCRETE, 4, inside)
    world.plan(-10.4, 3.6, 35.5)
    world.camera("overview", (4, -27, 20), (-10.5, 0.5, 0), 52)
    world.camera("aisle", (-3.2, -8.5, 3.2), (-3, 9, 0.4), 62)
    walls(world, inside)
    dice = random.Random(23)
    for name, (x, y) in numbered("column", [(x, y) for x in (west, east) for y in (-19, -11.5, -1, 6.5, 13.4, 24)]):
        side, y = 0.35 + 0.1 * int(4 * dice.random()), y + 3 * dice.random()
        body = world.body(name, x + math.copysign(side / 2, -10.4 - x), y)
        body.box("shaft", "column", (side, side, WALL - 0.05))
        body.box("guard", "yellow", (side + 0.03, side + 0.03, 1.0))
    for name, (x, width) in numbered("dock_door", [(-22.4, 3.2), (-15.2, 3.2), (-10.6, 2.4), (-4.1, 3.2), (2.4, 1.6)]):
        doorway(world, name, x, south, 90, width)
    for name, (x, y, yaw, width) in numbered(
        "door",
        [
            (west, -6.2, 0, 1.2),
            (west, 20.6, 0, 2.4),
            (east, 3.6, 180, 1.2),
            (-17.3, north, -90, 2.0),
            (-5.6, north, -90, 1.2),
        ],
    ):
        doorway(world, name, x, y, yaw, width)
    charging_station(world, "charging_station", -3.2, north - 0.25, -90)

    for name, (x, y, bays) in numbered(
        "rack", [(-20, -3.85, 4), (-16, -3.85, 3), (-12, 0.2, 3), (-8, -3.85, 4), (1.5, -3.85, 4)]
    ):
        rack(world, name, (x, y), int(bays), dice, guarded=(0, int(bays)), uneven=True)
    for index, (x, y, bays) in enumerate(
        [(-20, 16.05, 3), (-16, 18.5, 2), (-12, 16.05, 3), (-8, 16.05, 2), (1.5, 16.05, 3)], 6
    ):
        rack(world, f"rack_{index:02}", (x, y), int(bays), dice, guarded=(0, int(bays)), uneven=True)

    forklift(world, "forklift_01", -2.1, 10.0, 20)
    forklift(world, "forklift_02", -13.4, -15.0, -68)
    pallets = [
        (-20.0, -5.3, 90, 1.10),
        (-16.2, -5.7, 78, 1.30),
        (-7.9, -5.2, 90, 0.95),
        (1.3, -5.6, 97, 1.20),
        (-12.1, -0.9, 90, 1.05),
        (-16.0, 9.6, 84, 1.15),
        (-24.6, 3.1, 4, 1.20),
        (-24.7, 12.2, 90, 1.30),
        (-22.6, -19.2, 2, 1.15),
        (-16.9, -18.6, 14, 1.25),
        (-3.6, -19.3, 9, 1.10),
        (2.6, -18.7, 90, 1.30),
        (-8.2, 25.4, 82, 1.00),
        (-12.3, 29.2, 93, 1.10),
        (-9.6, 29.9, 4, 1.20),
        (-20.8, 29.8, 87, 0.95),
        (4.7, 20.4, 84, 1.15),
        (4.8, -3.6, 93, 1.05),
        (-25.5, -2.3, 5, 1.10),
    ]
    for index, (name, (x, y, yaw, height)) in enumerate(numbered("pallet", pallets)):
        pallet(world, name, (x, y, yaw), height, LOADS[index % len(LOADS)])
    for name, (x, y) in numbered("cone", [(0.2, 9.2), (0.2, 11.0), (-11.6, -13.4), (-15.0, -17.2)]):
        cone(world, name, x, y)
    for name, (x, y) in numbered(
        "barrel",
        [
            (4.5, -7.2),
            (4.6, -7.9),
            (3.9, -7.6),
            (4.5, -13.4),
            (-25.6, 16.2),
            (-6.2, 29.6),
            (5.1, 10.3),
            (-25.9, 10.7),
            (5.1, 18.3),
        ],
    ):
        barrel(world, name, x, y)
    paint = world.body("floor_markings")
    for part, x, y, size in (
        ("aisle_west", -6.8, 4.0, (0.1, 52)),
        ("aisle_east", 0.4, 4.0, (0.1, 52)),
        ("dock_north", -10.4, -11.5, (31, 0.1)),
        ("cross_south", -10.4, 13.1, (31, 0.1)),
        ("cross_north", -10.4, 15.3, (31, 0.1)),
    ):
        paint.box(part, "yellow", (*size, 0.002), (x, y, 0), contype="0", conaffinity="0")
    return world


def write_worlds(folder: Path) -> None:
    """Write each world into a folder."""
    for make in (flat_grid, table, simple_warehouse, full_warehouse, warehouse_features):
        make().write(folder)
    write_prints(folder / "prints")


if __name__ == "__main__":
    write_worlds(SHIPPED)
