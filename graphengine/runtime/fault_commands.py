"""The commands that let sensors and topics fail."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from graphengine.devices.robot_sensors import sensors_of
from graphengine.format.errors import UnknownEntityError
from graphengine.format.faults import Faults, Impairment
from graphengine.format.spec import Positive
from graphengine.format.wording import unknown
from graphengine.runtime.command import ChangeCommand, EntityName
from graphengine.runtime.session_core import SessionCore

MAX_DELAY = 60.0
"""Longest delay of a fault, s; memory holds the delayed samples and messages."""


class _Target(ChangeCommand):
    sensor: EntityName | None = None
    """Sensor, as ROBOT/SENSOR or the path of the sensor's prim."""
    topic: EntityName | None = None
    """Full name of a topic that graphs publish or read."""

    def _find(self, session: SessionCore) -> tuple[Faults, str]:
        """Return the faults of all sensors and the sensor's prim path, or the faults of all topics and the topic.

        Raises:
            UnknownEntityError: there is no such sensor or topic.
        """
        services, stage = session.services, session.services.stage
        if self.topic is not None:
            topics = sorted({claim.topic for claim in services.claims if not claim.is_service})
            if self.topic not in topics:
                raise UnknownEntityError(unknown("topic", self.topic, topics))
            return services.network.faults, self.topic
        assert self.sensor is not None
        known = {
            f"{name}/{sensor}": prim.path
            for name, robot in stage.robots().items()
            for sensor, prim in sensors_of(stage, robot).items()
        }
        path = known.get(self.sensor, self.sensor)
        if path not in known.values():
            raise UnknownEntityError(unknown("sensor", self.sensor, known))
        return services.world.faults, path


class Fault(_Target):
    """Make a sensor or topic silent, late or lossy from the next tick until a reset; a current fault is replaced."""

    silent: bool = False
    """Whether all samples or messages are lost."""
    dropout: Annotated[float, Field(gt=0, le=1)] | None = None
    """Probability with which each sample or message is lost; the seed of the session determines the losses."""
    delay: Annotated[Positive, Field(le=MAX_DELAY)] | None = None
    """Delay of samples or messages, s, rounded to whole ticks; their stamps stay the times of measurement."""
    duration: Positive | None = None
    """Simulation time after which the fault ends, s; default: `mend` ends it."""

    @model_validator(mode="after")
    def _whole(self) -> Fault:
        if (self.sensor is None) == (self.topic is None):
            raise ValueError("give a sensor or a topic")
        if self.silent == (self.dropout is not None or self.delay is not None):
            raise ValueError("give silent, or a dropout, a delay or both")
        return self

    def _apply(self, session: SessionCore) -> None:
        (acting, name), tick = self._find(session), session.clock.delta
        loss = 1.0 if self.silent else self.dropout or 0.0
        delay = max(round(self.delay / tick), 1) if self.delay is not None else 0
        ticks = max(round(self.duration / tick), 1) if self.duration is not None else None
        acting.put(name, Impairment(loss, delay, ticks, session.services.seed))
        self._record(session, **self.model_dump(exclude_defaults=True))


class Mend(_Target):
    """End the fault of a sensor or topic, or without arguments all faults. Data that is still delayed is lost."""

    @model_validator(mode="after")
    def _one(self) -> Mend:
        if self.sensor is not None and self.topic is not None:
            raise ValueError("give a sensor or a topic, or neither for all faults")
        return self

    def _apply(self, session: SessionCore) -> None:
        if self.sensor is None and self.topic is None:
            session.services.world.faults.clear()
            session.services.network.faults.clear()
        else:
            acting, name = self._find(session)
            acting.lift(name)
        self._record(session, **self.model_dump(exclude_defaults=True))
