"""The steps of a scenario, which are executed one after the other between the ticks of a session.

A step is executed by a generator, which yields once for each tick that the step lasts.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from typing import Annotated, Any

from pydantic import Field, create_model, field_validator, model_validator

from graphengine.api.expectations.conditions import Condition
from graphengine.api.expectations.readings import readings_of
from graphengine.api.session import Session
from graphengine.api.session_control import RECORDED_COMMANDS
from graphengine.api.values import plain
from graphengine.experiments.step_context import StepContext
from graphengine.experiments.waiting import WaitSpec
from graphengine.format.durations import in_seconds
from graphengine.format.errors import ExpectationError, UsageError
from graphengine.format.spec import Duration, FileSpec, Period, Spec
from graphengine.format.spec_reader import keys_of
from graphengine.format.wording import listing

Ticks = Iterator[None]

_COMMAND = "_command"
"""End of the names of the fields that are commands; the names of their keys are those of the commands."""


class PublishSpec(FileSpec):
    """A message that is sent once or periodically; the next step begins at once."""

    topic: str
    """Full name of the topic."""
    message: dict[str, Any]
    """Fields of the message."""
    type: str | None = None
    """Message type; needed if no graph uses the topic."""
    every: Period | None = None
    """Period; default: the message is sent once."""
    for_: Duration | None = Field(default=None, alias="for", description="Duration; default: to the end of the run.")

    def perform(self, context: StepContext) -> Ticks:
        """Send the message."""
        session = context.session
        publication = session.publish(self.topic, self.message, self.every, self.type)
        if self.for_ is not None:
            context.ending.append((session.time + self.for_, publication.close))
        return iter(())


class CallSpec(FileSpec):
    """A service call; the next step begins after the response."""

    service: str
    """Full name of the service."""
    request: dict[str, Any] = {}
    """Fields of the request."""
    type: str | None = None
    """Service type; needed if no graph uses the service."""
    response: dict[str, Any] = {}
    """Fields that the response must have; another value is an error."""

    def perform(self, context: StepContext) -> Ticks:
        """Call the service and wait for the response."""
        with context.session.start_call(self.service, self.request, self.type) as call:
            while not call.done:
                yield
        _check_fields(f"response of {self.service}", call.response, self.response)


class ActionSpec(FileSpec):
    """A goal of an action; the next step begins when the goal has ended."""

    name: str
    """Full name of the action."""
    type: str | None = None
    """Action type; needed if no graph uses the action."""
    goal: dict[str, Any] = {}
    """Fields of the goal."""
    result: str = "succeeded"
    """Status with which the goal must end: succeeded, canceled, aborted or rejected; another one is an error."""

    def perform(self, context: StepContext) -> Ticks:
        """Send the goal and wait for its end."""
        with context.session.send_goal(self.name, self.goal, self.type) as goal:
            while not goal.done:
                yield
        if goal.status != self.result:
            raise ExpectationError(f"action {self.name}: expected {self.result}, got {goal.status}")


def _check_fields(what: str, message: Any, wanted: Mapping[str, Any]) -> None:
    names = getattr(message, "__dataclass_fields__", {})
    for name, value in wanted.items():
        if name not in names:
            raise UsageError(f"{what}: no field {name!r}\n  {listing(names, 'fields')}")
        found = getattr(message, name)
        if isinstance(value, dict):
            _check_fields(f"{what}.{name}", found, value)
        elif plain(found) != value:
            raise ExpectationError(f"{what}: expected {name} = {value!r}, got {found!r}")


class _Step(FileSpec):
    """A step: one key, which names what to do."""

    publish: PublishSpec | None = None
    """Message to send, as {topic: /cmd_vel, message: {linear: {x: 0.5}}, every: 0.1s, for: 20s}."""
    wait: Duration | str | WaitSpec | None = None
    """Duration, or condition such as `pose("dd100").position[1] > 8`, or what to wait for, as {topic: /scan}."""
    call: CallSpec | None = None
    """Service to call, as {service: /set_bool, request: {data: true}}."""
    action: ActionSpec | None = None
    """Goal to send, as {name: /navigate_to_pose, goal: {pose: …}}."""
    start: Annotated[tuple[str, ...], Field(strict=False, min_length=1)] | None = None
    """Program to start, with its arguments; it ends with the run. Only with `--allow-programs`."""

    @field_validator("wait", mode="before")
    @classmethod
    def _duration_or_condition(cls, value: Any) -> Any:
        try:
            return in_seconds(value)
        except ValueError:
            return value

    @model_validator(mode="before")
    @classmethod
    def _has_one_key(cls, value: Any) -> Any:
        value = _with_seconds(value)
        known = [key for key in value if key in keys_of(cls)] if isinstance(value, dict) else []
        if len(known) > 1:
            raise ValueError(f"a step has one key, got {' and '.join(map(repr, known))}; write them as separate steps")
        if known and value[known[0]] is None:
            raise ValueError(f"{known[0]!r} needs a value")
        if value == {}:
            raise ValueError(f"expected a step; {listing(keys_of(cls), 'steps')}")
        return value

    def conditions(self) -> Iterator[str]:
        """Yield the conditions for which the step waits."""
        if isinstance(self.wait, str):
            yield self.wait

    def perform(self, context: StepContext) -> Ticks:
        """Execute the step.

        Raises:
            ExpectationError: a call or a goal has another result than the expected one.
            GraphError: the step cannot be executed.
        """
        (name,) = self.model_fields_set
        given = getattr(self, name)
        match name, given:
            case "parallel", _:
                return perform_together(given, context)
            case "start", _:
                return context.programs.start(given)
            case "wait", float():
                return _pass(context.session, given)
            case "wait", str():
                return _until(Condition(given, readings_of(context.session)))
        if name.endswith(_COMMAND):
            return _command(context, name.removesuffix(_COMMAND).replace("_", "-"), given)
        steps: Ticks = given.perform(context)
        return steps


def _with_seconds(step: Any) -> Any:
    """Return a step in which the durations of commands are seconds, also if they are written with a unit."""
    if not isinstance(step, dict):
        return step
    return {
        key: {**given, "duration": in_seconds(given["duration"])}
        if isinstance(given, dict) and "duration" in given
        else given
        for key, given in step.items()
    }


def _command_fields() -> dict[str, Any]:
    fields: dict[str, Any] = {}
    for name, kind in RECORDED_COMMANDS.items():
        about = Field(default=None, alias=name, description=(kind.__doc__ or "").partition("\n")[0])
        fields[name.replace("-", "_") + _COMMAND] = (kind | None, about)
    return fields


PlainStep = create_model("PlainStep", __base__=_Step, __module__=__name__, **_command_fields())
"""A step that is not `parallel`."""


_Sequence = Annotated[tuple[PlainStep, ...], Field(strict=False)]  # type: ignore[valid-type]


class StepSpec(PlainStep):  # type: ignore[valid-type, misc]
    """A step, or several sequences of steps that are executed at the same time."""

    parallel: Annotated[tuple[_Sequence, ...], Field(strict=False, min_length=1)] | None = None
    """Lists of steps that are executed at the same time; the next step begins when all have ended."""

    def conditions(self) -> Iterator[str]:
        """Yield the conditions for which the step and its parallel steps wait."""
        yield from super().conditions()
        for step in itertools.chain.from_iterable(self.parallel or ()):
            yield from _Step.conditions(step)


def perform_all(steps: Any, context: StepContext) -> Ticks:
    """Execute steps one after the other."""
    for step in steps:
        yield from step.perform(context)


def perform_together(sequences: Any, context: StepContext) -> Ticks:
    """Execute sequences of steps at the same time."""
    running = [perform_all(steps, context) for steps in sequences]
    while running:
        running = [steps for steps in running if next(steps, context) is not context]
        if running:
            yield


def _command(context: StepContext, name: str, arguments: Spec) -> Ticks:
    future = context.session.submit(name, arguments.model_dump(mode="json", exclude_unset=True))
    while not future.done():
        yield
    future.result()


def _pass(session: Session, duration: float) -> Ticks:
    end = session.time + duration - 1e-9
    while session.time < end:
        yield


def _until(condition: Condition) -> Ticks:
    while (sample := condition.sample()) is None or not sample.holds:
        yield
