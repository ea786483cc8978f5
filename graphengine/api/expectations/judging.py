"""Judges expectations after each tick with one generated function, which evaluates each reading once."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, Protocol

from graphengine.api.after_tick import AfterTick
from graphengine.api.expectations.conditions import Condition
from graphengine.api.expectations.operators import Operator
from graphengine.api.expectations.readings import Source
from graphengine.api.expectations.sampling_code import SamplingCode


class Judged(Protocol):
    """An expectation that `Judging` judges, such as an `ExpectationCheck`."""

    trace: list[tuple[float, float]] | None
    error: str
    operator: Operator

    @property
    def conditions(self) -> Sequence[Condition]:
        """The conditions whose samples the operator judges."""

    @property
    def inverted(self) -> bool:
        """Whether the operator judges the opposite of the condition."""

    def save(self) -> Any:
        """Return a copy of the state."""

    def restore(self, saved: Any) -> None:
        """Restore a saved state."""

    def restart(self) -> None:
        """Restart the judgement at the current time."""

    def find_error(self) -> None:
        """Set `error` if a condition cannot be sampled now."""

    def end(self) -> None:
        """Decide the outcome at the end of the run."""

    def note_values(self) -> None:
        """Keep the values of the readings after the decision."""


class Judging(AfterTick):
    """The judgement of expectations that began in the same tick. A reset of the time restarts it; checkpoints contain its state.

    Args:
        source: the session or the bag.
        checks: the expectations to judge.
    """

    def __init__(self, source: Source, *checks: Judged) -> None:
        self._source = source
        self.checks = checks
        self._frame = source.tick
        self._restarting: Iterable[Judged] = ()
        """Checks to restart in the next tick, because they began after the checkpoint that was restored."""
        self._judge: Callable[[float], Exception | None] | None = None
        """Judges all checks without an error at a time; None after a change of these checks."""

    @property
    def is_new(self) -> bool:
        """Whether no tick has passed since the beginning or since the last judgement."""
        return self._frame == self._source.tick

    def change(self, *checks: Judged) -> None:
        """Judge these checks from the next tick on."""
        self.checks, self._judge = checks, None

    def save(self) -> Any:
        """Return a copy of the states of all checks."""
        return self._frame, {check: check.save() for check in self.checks}

    def restore(self, saved: Any) -> None:
        """Restore saved states."""
        self._frame, states = saved
        for check, state in states.items():
            check.restore(state)
        self._restarting, self._judge = [check for check in self.checks if check not in states], None

    def after_tick(self, frame: int) -> None:
        """Judge the state after a tick; `frame` is the number of ticks since the start or since the last reset of the time."""
        if frame <= self._frame or self._restarting:
            for check in self.checks if frame <= self._frame else self._restarting:
                check.restart()
            self._restarting, self._judge = (), None
        self._frame, time = frame, self._source.time
        if self._judge is None:
            self._judge = self._generated()
        if self._judge(time) is not None:
            for check in self.checks:
                check.find_error()
            self._judge = self._generated()
            if (error := self._judge(time)) is not None:
                raise error

    def _generated(self) -> Callable[[float], Exception | None]:
        """Return a function that judges all checks without an error. If a condition raises an error, it returns the error."""
        code, lines = SamplingCode(time="time"), []
        for check in self.checks:
            if not check.error:
                lines += _judgement(code, check)
        return code.function(lines, "return error")


def _judgement(code: SamplingCode, check: Judged) -> list[str]:
    """Add the conditions of a check to generated code, and return the statements that judge their samples."""
    samples = [code.add(condition) for condition in check.conditions]
    present = [f"{sample[0]} is not None" for sample, c in zip(samples, check.conditions, strict=True) if c.arrives]
    if check.inverted:
        samples = [[f"not {holds}", f"-{margin}"] for holds, margin in samples]
    name, arguments = code.constant(check), ", ".join(part for sample in samples for part in sample)
    lines = [
        f"operator = {name}.operator",
        f"if {samples[0][0]} and {samples[0][1]} >= operator.quiet: operator.now = time",
        f"elif operator.add(time, {arguments}): {name}.note_values()",
    ]
    if check.trace is not None:
        lines.append(f"{name}.trace.append((time, float(min([{', '.join(margin for _, margin in samples)}]))))")
    return [f"if {' and '.join(present)}:", *(f" {line}" for line in lines)] if present else lines
