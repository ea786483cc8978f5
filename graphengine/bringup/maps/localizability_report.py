"""Reports localizability as a text summary, a CSV table and a PNG image."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from graphengine.bringup.maps.localizability import Localizability
from graphengine.descriptions.engine import Bools
from graphengine.format.atomic_write import write_together
from graphengine.physics.occupancy.flood_fill import reached
from graphengine.physics.occupancy.occupancy_map import FREE, OCCUPIED, OccupancyMap

GOOD_SPREAD, GOOD_AMBIGUITY = 0.10, 0.5
"""Largest spread (m) and largest ambiguity of a pose that counts as good."""
BLIND = 2 * GOOD_SPREAD
REGIONS = 5
_HEAD = ("x", "y", "spread", "direction_deg", "near", "far", "alias_x", "alias_y", "heading_deg", "alias_heading_deg")
_GREEN, _YELLOW, _RED = (60, 160, 90), (240, 200, 60), (200, 50, 50)


def write_report(result: Localizability, chart: OccupancyMap, stem: Path) -> list[Path]:
    """Write `stem`.png and `stem`.csv, both or neither; return their paths.

    Raises:
        OSError: a file cannot be written.
    """
    contents = {
        stem.with_name(f"{stem.name}.png"): _picture(result, chart),
        stem.with_name(f"{stem.name}.csv"): _table(result),
    }
    write_together(contents)
    return list(contents)


def summary(result: Localizability) -> str:
    """Return a text with the shares of good and bad poses, and the regions in which bad poses are."""
    spread, ambiguity = result.spread, result.ambiguity
    good = _percent((spread <= GOOD_SPREAD) & (ambiguity <= GOOD_AMBIGUITY))
    near, far = _percent(result.near <= GOOD_AMBIGUITY), _percent(result.far <= GOOD_AMBIGUITY)
    bounds = f"spread at most {GOOD_SPREAD:.2f} m, ambiguity at most {GOOD_AMBIGUITY:g}"
    lines = [
        f"{len(result.places)} places, {len(result.headings)} headings: {good} of the poses are good ({bounds})",
        f"spread: median {np.median(spread):.3f} m, 97 % of the poses at most {np.quantile(spread, 0.97):.3f} m",
        f"ambiguity: at most {GOOD_AMBIGUITY:g} with nearby poses for {near} of the poses, with others for {far}",
    ]
    across = np.abs(np.sin(result.direction)) > math.sqrt(0.5)
    for words, bad in (
        ("blind along x", (spread > BLIND) & ~across),
        ("blind along y", (spread > BLIND) & across),
        ("imprecise along x", (spread > GOOD_SPREAD) & (spread <= BLIND) & ~across),
        ("imprecise along y", (spread > GOOD_SPREAD) & (spread <= BLIND) & across),
        ("ambiguous nearby", result.near > GOOD_AMBIGUITY),
        ("ambiguous with another place", result.far > GOOD_AMBIGUITY),
    ):
        if bad.any():
            regions = "; ".join(_regions(result, bad.mean(axis=1) >= 0.25))
            lines.append(f"{_percent(bad)} of the free space is {words}: {regions}")
    return "\n".join(lines)


def _percent(which: Bools) -> str:
    return f"{100 * which.mean():.1f} %"


def _regions(result: Localizability, bad: Bools) -> Iterator[str]:
    """Yield texts with the extents of the largest connected regions of `bad` places."""
    low = result.places.min(axis=0)
    cells = np.rint((result.places - low) / result.spacing).astype(np.intp)
    plan = np.zeros(cells.max(axis=0)[::-1] + 1, np.bool_)
    plan[cells[bad, 1], cells[bad, 0]] = True
    regions = []
    while plan.any():
        row, column = (int(index[0]) for index in np.nonzero(plan))
        region = reached(plan, [(row, column)])
        plan &= ~region
        regions.append(region)
    regions.sort(key=lambda region: -int(region.sum()))
    for region in regions[:REGIONS]:
        rows, columns = np.nonzero(region)
        west, south = low + result.spacing * (np.array([columns.min(), rows.min()]) - 0.5)
        east, north = low + result.spacing * (np.array([columns.max(), rows.max()]) + 0.5)
        yield f"x {west:.1f} to {east:.1f}, y {south:.1f} to {north:.1f} m ({len(rows)} places)"
    if not regions:
        yield "scattered"
    elif len(regions) > REGIONS:
        yield f"and {len(regions) - REGIONS} smaller regions"


def _table(result: Localizability) -> bytes:
    """Return a CSV table with a row for each place.

    Spread, near ambiguity and far ambiguity are the largest values over all headings. Heading and alias belong to the largest far
    ambiguity.
    """
    buffer = io.StringIO()
    rows = csv.writer(buffer, lineterminator="\n")
    rows.writerow(_HEAD)
    for index, (x, y) in enumerate(result.places.tolist()):
        wide, aliased = int(result.spread[index].argmax()), int(result.far[index].argmax())
        alias_x, alias_y, turned = result.alias[index, aliased].tolist()
        heading = math.degrees(result.headings[aliased])
        values = (
            f"{x:.3f}", f"{y:.3f}", f"{result.spread[index, wide]:.4f}", f"{math.degrees(result.direction[index, wide]):.0f}",
            f"{result.near[index].max():.4f}", f"{result.far[index, aliased]:.4f}",
        )  # fmt: skip
        other = ("", "", f"{heading:.1f}", "") if math.isnan(alias_x) else (
            f"{alias_x:.3f}", f"{alias_y:.3f}", f"{heading:.1f}", f"{math.degrees(turned):.1f}"
        )  # fmt: skip
        rows.writerow((*values, *other))
    return buffer.getvalue().encode()


def _picture(result: Localizability, chart: OccupancyMap) -> bytes:
    """Return a PNG image with two maps: one coloured by spread with lines along the worst directions, one by ambiguity."""
    plan = np.full((*chart.cells.shape, 3), 170, np.uint8)
    plan[chart.cells == FREE], plan[chart.cells == OCCUPIED] = 255, 0
    worst = result.spread.argmax(axis=1)
    each = np.arange(len(worst))
    spread, direction = result.spread[each, worst], result.direction[each, worst]
    panels = (
        ("spread: green 0, yellow 0.10 m, red 0.20 m and more", spread / BLIND),
        ("ambiguity: green 0, yellow 0.5, red 1", result.ambiguity.max(axis=1)),
    )
    high, wide = chart.cells.shape
    image = Image.new("RGB", (2 * wide + 10, high + 20), "white")
    for panel, (title, badness) in enumerate(panels):
        part = Image.fromarray(plan[::-1].copy())
        draw = ImageDraw.Draw(part)
        half = max(1.0, 0.4 * result.spacing / chart.grid.cell)
        for index, (x, y) in enumerate(result.places.tolist()):
            column, row = (x - chart.grid.west) / chart.grid.cell, high - (y - chart.grid.south) / chart.grid.cell
            draw.rectangle((column - half, row - half, column + half, row + half), fill=_colour(float(badness[index])))
            if not panel and spread[index] > GOOD_SPREAD:
                dx, dy = half * math.cos(direction[index]), -half * math.sin(direction[index])
                draw.line((column - dx, row - dy, column + dx, row + dy), fill="black")
        image.paste(part, (panel * (wide + 10), 20))
        ImageDraw.Draw(image).text((panel * (wide + 10) + 4, 4), title, fill="black")
    buffer = io.BytesIO()
    image.save(buffer, "PNG")
    return buffer.getvalue()


def _colour(badness: float) -> tuple[int, int, int]:
    """Return a colour on a scale from green (0) over yellow (0.5) to red (1)."""
    channels = zip(_GREEN, _YELLOW, _RED, strict=True)
    red, green, blue = (round(float(np.interp(badness, (0.0, 0.5, 1.0), each))) for each in channels)
    return red, green, blue
