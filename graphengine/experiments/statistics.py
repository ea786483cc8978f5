"""The share of passed runs, with its confidence interval."""

from __future__ import annotations

import math

Z = 1.959963984540054
"""Quantile of the normal distribution for a confidence of 95 %."""


def wilson_interval(passed: int, runs: int) -> tuple[float, float]:
    """Return the limits of the probability that a run passes, with a confidence of 95 %.

    E. B. Wilson, "Probable Inference, the Law of Succession, and Statistical Inference", 1927.

    >>> [round(limit, 3) for limit in wilson_interval(18, 20)]
    [0.699, 0.972]
    """
    share, weight = passed / runs, Z * Z / runs
    middle = (share + weight / 2.0) / (1.0 + weight)
    half = Z * math.sqrt(share * (1.0 - share) / runs + weight / (4.0 * runs)) / (1.0 + weight)
    return max(0.0, middle - half), min(1.0, middle + half)


def rerun_text(failures: int, runs: int) -> str:
    """Return how often a failed case failed when it was run several times with the same seed.

    >>> rerun_text(1, 20), rerun_text(20, 20)
    ('failed in 1 of 20', 'failed always, in 20 of 20')
    """
    return f"failed {'always, ' if failures == runs else ''}in {failures} of {runs}"
