"""Motion noise of AMCL for a calibrated robot."""

from __future__ import annotations

from graphengine.api.calibration.figures import Calibration

DEFAULT = 0.01


def amcl_alphas(result: Calibration) -> tuple[float, float, float, float, float]:
    """Return alpha1 to alpha5 of AMCL's motion model."""
    return (DEFAULT,) * 5
