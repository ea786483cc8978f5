"""An `asyncio` in which everything that is waited for has happened: coroutines run to their end when they are started."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Generator
from typing import Any

from graphengine.omnigraph.recorder import Recorder
from graphengine.omnigraph.stand_in import StandIn, StandInModule, idle


def asyncio_stand_in(recorder: Recorder) -> StandInModule:
    """An `asyncio` in which everything that is waited for has happened."""

    class Task:
        """A coroutine that came to its end."""

        def __init__(self, value: Any) -> None:
            self.value = value

        def result(self) -> Any:
            return self.value

        def done(self) -> bool:
            return True

        def __await__(self) -> Generator[Any, None, Any]:
            yield from ()
            return self.value

        def __getattr__(self, name: str) -> Any:
            return StandIn(f"asyncio.Task.{name}", recorder)

    def finish(awaitable: Any, *more: Any, **named: Any) -> Any:
        if isinstance(awaitable, Task):
            return awaitable.value
        steps: Coroutine[Any, Any, Any] = awaitable if hasattr(awaitable, "send") else _waiting(awaitable)
        try:
            while True:
                steps.send(None)
                idle(recorder)
        except StopIteration as end:
            return end.value

    def start(awaitable: Any, *_: Any, **__: Any) -> Task:
        return Task(finish(awaitable))

    def sleep(*_: Any) -> Task:
        idle(recorder)
        return Task(None)

    def gather(*awaitables: Any, **_: Any) -> Task:
        return Task([finish(one) for one in awaitables])

    members: dict[str, Callable[..., Any]] = {
        "run": finish,
        "wait_for": start,
        "shield": start,
        "ensure_future": start,
        "create_task": start,
        "gather": gather,
        "sleep": sleep,
    }
    loop = StandIn("asyncio.loop", recorder)
    loop.__dict__.update(run_until_complete=finish, create_task=start)
    asking = dict.fromkeys(("get_event_loop", "get_running_loop", "new_event_loop"), lambda: loop)
    return StandInModule("asyncio", recorder, {}, {**members, **asking})


async def _waiting(awaitable: Any) -> Any:
    return await awaitable
