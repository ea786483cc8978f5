"""What is written onto an MjSpec is what MuJoCo's own reader of URDF reads from the same text, to the last bit."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.descriptions.engine import mujoco
from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.references import Library
from graphengine.descriptions.files.xml import number, parse
from graphengine.descriptions.mujoco_writer import write_robot
from graphengine.descriptions.urdf.urdf_reader import read_urdf
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files

COMPILER = '<mujoco><compiler fusestatic="false" discardvisual="false"/></mujoco>'

quarters = st.sampled_from([0.0, -0.0, math.pi / 2, -math.pi / 2, math.pi, -math.pi, 1.5 * math.pi])
angles = st.one_of(quarters, st.floats(-7, 7))
lengths = st.one_of(st.sampled_from([0.0, -0.0]), st.floats(-3, 3, allow_subnormal=False))
sizes = st.floats(0.01, 2)
origins = st.tuples(lengths, lengths, lengths, angles, angles, angles).map(
    lambda v: f'<origin xyz="{v[0]!r} {v[1]!r} {v[2]!r}" rpy="{v[3]!r} {v[4]!r} {v[5]!r}"/>'
)
shapes = st.one_of(
    st.tuples(sizes, sizes, sizes).map(lambda v: f'<box size="{v[0]!r} {v[1]!r} {v[2]!r}"/>'),
    st.tuples(sizes, sizes).map(lambda v: f'<cylinder radius="{v[0]!r}" length="{v[1]!r}"/>'),
    st.tuples(sizes, sizes).map(lambda v: f'<capsule radius="{v[0]!r}" length="{v[1]!r}"/>'),
    sizes.map(lambda radius: f'<sphere radius="{radius!r}"/>'),
)
colours = st.one_of(
    st.just(""), st.floats(0, 1).map(lambda red: f'<material name="m"><color rgba="{red!r} .2 .3 1"/></material>')
)
parts = st.lists(
    st.tuples(st.sampled_from(["visual", "collision"]), origins, shapes, colours),
    max_size=4,
).map(
    lambda found: [f"{tag}>{origin}<geometry>{shape}</geometry>{colour}</{tag}" for tag, origin, shape, colour in found]
)
moments = st.tuples(*(3 * [st.floats(0.7, 1)]), *(3 * [st.floats(-0.05, 0.05)]))  # always possible: 0.6 + 0.6 > 1.1
limits = st.one_of(
    st.just(""),
    st.tuples(lengths, lengths, st.floats(-50, 50)).map(
        lambda v: f'<limit lower="{v[0]!r}" upper="{v[1]!r}" effort="{v[2]!r}"/>'
    ),
    lengths.map(lambda lower: f'<limit lower="{lower!r}"/>'),
)
axes = st.tuples(lengths, lengths, lengths).filter(lambda v: math.hypot(*v) > 0.01)


@st.composite
def links(draw: st.DrawFn, name: str) -> str:
    """A link with a mass, colliders and visuals."""
    terms = zip(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), draw(moments), strict=True)
    inertia = " ".join(f'{term}="{moment!r}"' for term, moment in terms)
    inertial = f'<inertial>{draw(origins)}<mass value="{draw(sizes)!r}"/><inertia {inertia}/></inertial>'
    named = (part.replace(">", f' name="{name}.{index}.0">', 1) for index, part in enumerate(draw(parts), 1))
    return f'<link name="{name}">{inertial}{"".join(f"<{part}>" for part in named)}</link>'


@st.composite
def robots(draw: st.DrawFn) -> str:
    """A robot of two links; MuJoCo's reader would name its geoms as they are named in the text."""
    kind = draw(st.sampled_from(["revolute", "continuous", "prismatic", "fixed"]))
    x, y, z = draw(axes)
    friction = f'<dynamics damping="{draw(sizes)!r}" friction="{draw(sizes)!r}"/>'
    ends = f'<parent link="a"/><child link="b"/><axis xyz="{x!r} {y!r} {z!r}"/>'
    joint = f'<joint name="j" type="{kind}">{draw(origins)}{ends}{draw(limits)}{friction}</joint>'
    return f'<robot name="r">{COMPILER}{draw(links("a"))}{draw(links("b"))}{joint}</robot>'


def written(text: str) -> tuple[mujoco.MjSpec | None, Findings]:
    """Return the MjSpec of a URDF, None after an error, and the findings."""
    findings, files = Findings(), Files((Path("/nowhere"),))
    root = parse(text.encode(), "r.urdf", findings, "S103")
    assert root is not None
    urdf = read_urdf(root, Packages(Path("/nowhere"), (), files), findings)
    if urdf is None:
        return None, findings
    library = Library(files, findings)
    return write_robot(urdf, "r", library, findings, free_link=None, colours={}, more=0.0), findings


@given(robots())
def test_each_array_agrees_with_mujocos_reader(text: str) -> None:
    spec, _ = written(text)
    assert spec is not None
    ours, theirs = spec.compile(), mujoco.MjSpec.from_string(text).compile()
    for name in dir(theirs):
        wanted = getattr(theirs, name) if not name.startswith("_") else None
        if isinstance(wanted, np.ndarray):
            assert getattr(ours, name).tobytes() == wanted.tobytes(), name


@pytest.mark.parametrize("text", ["1_0", "\u0661", "\uff11.5"])
def test_texts_that_only_python_reads_as_numbers_are_not_numbers(text: str) -> None:
    assert number(text) is None


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ('boundmass="x"', "boundmass must be a number, not 'x'"),
        ('balanceinertia="yes"', "balanceinertia must be true or false, not 'yes'"),
        ('inertiafromgeom="maybe"', "inertiafromgeom must be true, false or auto, not 'maybe'"),
    ],
)
def test_illegal_settings_of_the_compiler_are_errors(settings: str, told: str) -> None:
    spec, findings = written(f'<robot name="r"><mujoco><compiler {settings}/></mujoco><link name="a"/></robot>')
    assert spec is None
    assert [told in finding.message for finding in findings.errors] == [True]


def test_a_colour_beyond_single_precision_is_an_error() -> None:
    material = '<material name="m"><color rgba="1e299 0 0 1"/></material>'
    visual = f'<visual><geometry><sphere radius="1"/></geometry>{material}</visual>'
    _, findings = written(f'<robot name="r"><link name="a">{visual}</link></robot>')
    assert "color rgba must be four numbers" in findings.errors[0].message
