"""A stub of `asyncio` that never waits: coroutines run to completion when they are started."""

from __future__ import annotations

from collections.abc import Coroutine, Generator
from typing import Any

from graphengine.isaac.omniverse.script_notes import ScriptNotes
from graphengine.isaac.omniverse.stubs import StubModule, StubObject, member


class Task:
    """Stub of `asyncio.Task` that holds the result of a coroutine which has already run to completion."""

    def __init__(self, value: Any, recorder: ScriptNotes) -> None:
        self._value, self._recorder = value, recorder

    def result(self) -> Any:
        """Return the result of the coroutine."""
        return self._value

    def done(self) -> bool:
        """Return True: the coroutine ran to completion when it was started."""
        return True

    def __await__(self) -> Generator[Any, None, Any]:
        yield from ()
        return self._value

    def __getattr__(self, name: str) -> Any:
        return member("asyncio.Task", name, self._recorder)


def finish(awaitable: Any, recorder: ScriptNotes) -> Any:
    """Run an awaitable to completion without an event loop and return its result."""
    if isinstance(awaitable, Task):
        return awaitable.result()
    steps: Coroutine[Any, Any, Any] = awaitable if hasattr(awaitable, "send") else _waiting(awaitable)
    try:
        while True:
            steps.send(None)
            recorder.idle()
    except StopIteration as end:
        return end.value


def make_asyncio(recorder: ScriptNotes) -> StubModule:
    """Return a stub of the module `asyncio` that runs each coroutine to completion when it is started."""

    def run(awaitable: Any, *_: Any, **__: Any) -> Any:
        return finish(awaitable, recorder)

    def start(awaitable: Any, *_: Any, **__: Any) -> Task:
        return Task(finish(awaitable, recorder), recorder)

    def sleep(*_: Any) -> Task:
        recorder.draw()
        return Task(None, recorder)

    def gather(*awaitables: Any, **_: Any) -> Task:
        return Task([finish(one, recorder) for one in awaitables], recorder)

    loop = StubObject("asyncio.loop", recorder)
    vars(loop).update(run_until_complete=run, create_task=start)
    starting = dict.fromkeys(("wait_for", "shield", "ensure_future", "create_task"), start)
    asking = dict.fromkeys(("get_event_loop", "get_running_loop", "new_event_loop"), lambda: loop)
    members = {"run": run, "gather": gather, "sleep": sleep, **starting, **asking}
    return StubModule("asyncio", recorder, {}, members)


async def _waiting(awaitable: Any) -> Any:
    return await awaitable
