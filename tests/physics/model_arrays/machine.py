"""Tells machines apart whose last bits differ: their mathematical library, or the linear algebra of their numpy."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from tests.physics.model_arrays.figures import digest, figures

_MODEL = """<mujoco><compiler angle="radian" eulerseq="zyx"/>
<asset><mesh name="m" vertex="0 0 0  .3 .02 .01  .01 .2 0  .03 .05 .15  .21 .17 .11"/></asset>
<worldbody><body euler=".1 .2 .3"><joint name="j" axis="1 2 3"/><geom type="mesh" mesh="m"/>
<body pos=".1 0 .2" axisangle="1 2 1 .7"><joint axis="0 1 2"/>
<inertial pos="0 0 .1" mass="1" fullinertia=".02 .03 .025 .001 -.002 .003"/></body></body></worldbody></mujoco>"""


def probe() -> str:
    """Return a digest of what this machine computes; if two machines have the same one, they make the same models, bit by bit.

    It covers sines and other functions of the system's library, eigenvalues by numpy, and a model that MuJoCo compiles alone.
    """
    steps = [(0.61803398875 * number) % 1.0 for number in range(1, 2000)]
    values = [
        value
        for x in steps
        for value in (math.sin(9 * x), math.cos(9 * x), math.atan2(x, 0.7), math.asin(x), math.exp(x))
    ]
    matrices = np.array(steps[:1800]).reshape(-1, 3, 3)
    moments, axes = np.linalg.eigh(matrices + matrices.transpose(0, 2, 1))
    products = (axes * moments[:, None, :]) @ axes.transpose(0, 2, 1)
    compiled = figures(mujoco.MjModel.from_xml_string(_MODEL))
    numbers = [array.astype(np.float64).ravel() for array in compiled.values() if array.dtype.kind == "f"]
    return digest(np.concatenate([np.array(values), moments.ravel(), axes.ravel(), products.ravel(), *numbers]))
