"""Writes the page: one HTML file with its script, style and data, which makes no network requests.

All names and texts of a recording are in the compressed data, except for the title. The content security policy allows only the
page's own scripts and style, by their digests, and no text can become HTML (`require-trusted-types-for`).
"""

from __future__ import annotations

import html
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib import resources
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from graphengine.drawing.page import digest
from graphengine.format.atomic_write import write_together
from graphengine.view.html.payload import Payload
from graphengine.view.html.scene_data import SceneData
from graphengine.view.html.trace import SceneTrace


@dataclass(frozen=True, slots=True)
class Plot:
    """Values over time.

    Attributes:
        name: name of the values.
        times: times since the beginning of the recording, s, in ascending order.
        values: one value per time; a value that is not finite leaves a gap.
        unit: unit of the values; empty without a unit.
        limits: smallest and largest legal value; None where there is no limit.
    """

    name: str
    times: ArrayLike
    values: ArrayLike
    unit: str = ""
    limits: tuple[float | None, float | None] = (None, None)


@dataclass(frozen=True, slots=True)
class LogEntry:
    """A message of the log.

    Attributes:
        tick: number of the tick in which the message was logged.
        kind: severity, such as `warning`.
        text: the message.
    """

    tick: int
    kind: str
    text: str


def write_html(
    trace: SceneTrace,
    path: Path,
    *,
    title: str,
    plots: Sequence[Plot] = (),
    marks: Sequence[LogEntry] = (),
    log: Sequence[LogEntry] = (),
) -> None:
    """Write a run as one HTML file; an older file is replaced when the new one is complete.

    Args:
        trace: samples of the run.
        path: file to write.
        title: title of the page.
        plots: values over time.
        marks: events on the time bar; the log lists them too.
        log: further messages of the log.

    Raises:
        OSError: the file cannot be written.
    """
    payload = Payload()
    scenes = SceneData(payload)
    stages = [scenes.stage(stage, trace) for stage in trace.stages]
    told = [*marks, *log]
    events = [{**asdict(event), "time": event.tick * trace.period} for event in told]
    values = {
        "duration": trace.stages[-1].ticks[-1] * trace.period,
        "step": trace.period,
        "stages": stages,
        "surfaces": scenes.surfaces,
        "textures": scenes.textures,
        "plots": [_plot(plot, payload) for plot in plots],
        "marks": events[: len(marks)],
        "log": sorted(events, key=lambda event: event["tick"]),
    }
    write_together({path: _page(title, payload.text(values)).encode()})


def robot_plots(trace: SceneTrace) -> Sequence[Plot]:
    """Return speed and turn rate of the first robots of a run."""
    plots = []
    for name, samples in trace.speeds.items():
        times, speeds, turns = zip(*samples, strict=True)
        plots += [Plot(f"{name}: speed", times, speeds, "m/s"), Plot(f"{name}: turn rate", times, turns, "rad/s")]
    return plots


def _plot(plot: Plot, payload: Payload) -> Mapping[str, Any]:
    limits = [limit if limit is not None and math.isfinite(limit) else None for limit in plot.limits]
    times, values = (payload.put(np.asarray(numbers, float)) for numbers in (plot.times, plot.values))
    return {"name": plot.name, "unit": plot.unit, "limits": limits, "times": times, "values": values}


def _page(title: str, data: str) -> str:
    names = ("uplot.css", "page.css", "uplot.js", "bundle.js")
    library_style, own_style, library, script = (_file(name) for name in names)
    style = f"{library_style}\n{own_style}"
    policy = (
        f"default-src 'none'; script-src {digest(library)} {digest(script)}; style-src {digest(style)}; base-uri 'none'; "
        "form-action 'none'; require-trusted-types-for 'script'; trusted-types 'none'"
    )
    return Template(_file("page.html")).substitute(
        policy=policy, title=html.escape(title), style=style, data=data, library=library, script=script
    )


def _file(name: str) -> str:
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")
