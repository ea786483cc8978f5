"""The entries of `metrics:` in a scenario file, such as `top_speed: {max: velocity("dd100").linear[0]}`."""

from __future__ import annotations

from typing import Any

from pydantic import model_validator

from graphengine.api.expectations.metrics import FOLDS, Metric
from graphengine.format.spec import FileSpec
from graphengine.format.wording import listing


class MetricSpec(FileSpec):
    """A number that describes a run: one operator, with its expression."""

    min: str | None = None
    """Expression whose smallest value in all ticks is the metric."""
    max: str | None = None
    """Expression whose largest value in all ticks is the metric, as `velocity("dd100").linear[0]`."""
    mean: str | None = None
    """Expression whose mean over all ticks is the metric."""
    final: str | None = None
    """Expression whose value in the last tick is the metric."""
    time_to: str | None = None
    """Condition; the metric is the simulation time at which it first holds, s."""

    @model_validator(mode="before")
    @classmethod
    def _is_one_operator(cls, value: Any) -> Any:
        if isinstance(value, dict) and len(known := [key for key in value if key in FOLDS]) != 1:
            found = " and ".join(map(repr, known)) or "none"
            raise ValueError(f"expected one operator, got {found}; {listing(FOLDS, 'operators')}")
        return value

    def metric(self) -> Metric:
        """Return the metric."""
        (operator,) = self.model_fields_set
        return Metric(operator, getattr(self, operator))
