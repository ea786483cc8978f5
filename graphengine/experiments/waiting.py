"""The step `wait` for other programs: for a message, a node, a service or a state of a lifecycle node."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Literal

from pydantic import Field, model_validator

from graphengine.experiments.step_context import StepContext
from graphengine.format.spec import FileSpec
from graphengine.format.wording import listing


class WaitSpec(FileSpec):
    """The event for which a step waits: one of `topic`, `node`, `service` and `lifecycle`."""

    topic: str | None = None
    """Topic on which a message arrives."""
    type: str | None = None
    """Message type of the topic or service type; needed if no graph uses the topic or service."""
    node: str | None = None
    """ROS node that is running, such as /controller_server."""
    service: str | None = None
    """Service that has a server."""
    lifecycle: str | None = None
    """Lifecycle node that reaches the state `state`."""
    state: Literal["unconfigured", "inactive", "active", "finalized"] = Field(default="active")
    """State of the lifecycle node."""

    @model_validator(mode="after")
    def _is_one(self) -> WaitSpec:
        kinds = ("topic", "node", "service", "lifecycle")
        if len([kind for kind in kinds if getattr(self, kind) is not None]) != 1:
            raise ValueError(f"expected one of these; {listing(kinds, 'what to wait for')}")
        return self

    def perform(self, context: StepContext) -> Iterator[None]:
        """Yield between two ticks until the event occurs."""
        session = context.session
        if self.topic is not None:
            subscription = session.subscribe(self.topic, self.type, keep=1)
            while not subscription.received:
                yield
            subscription.close()
        elif self.node is not None:
            name = f"/{self.node.lstrip('/')}"
            while name not in session.nodes():
                yield
        elif self.service is not None:
            with session.start_call(self.service, None, self.type) as call:
                while not call.ready:
                    yield
        else:
            yield from self._wait_for_state(session)

    def _wait_for_state(self, session: Any) -> Iterator[None]:
        service = f"/{str(self.lifecycle).strip('/')}/get_state"
        while True:
            with session.start_call(service, {}, "lifecycle_msgs/srv/GetState") as call:
                while not call.done:
                    yield
            if call.response.current_state.label == self.state:
                return
            end = session.time + 0.2
            while session.time < end:
                yield
