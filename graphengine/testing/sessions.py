"""Starts sessions for tests of graphs and scenes."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterator
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from graphengine.api.scene import Scene
    from graphengine.api.session import Session

FixtureScope = Literal["function", "class", "module", "package", "session"]


def session(source: str | PathLike[str], **arguments: Any) -> Session:
    """Load a scene or graph, start a session of it and return the session, for a `with` statement.

        with session("dd100_flat", set={"DiffController.maxLinearSpeed": 0.5}, seed=1) as sim:
            sim.step()

    Args:
        source: path of a file, or name of a scene or graph in the package.
        arguments: keyword arguments of `graphengine.load` and `Scene.session`.

    Raises:
        CheckError: the files have errors.
    """
    scene, of_session = _loader(source, arguments)
    return scene().session(**of_session)


def session_fixture(
    source: str | PathLike[str],
    *,
    scope: FixtureScope = "function",
    **arguments: Any,
) -> Any:
    """Return a pytest fixture that starts a session and closes it at the end of `scope`; the scene is loaded only once.

        sim = session_fixture("dd100_flat", seed=1)

        def test_a_robot_at_rest_stays(sim):
            assert sim.run(1.0) and sim.robots["dd100"].velocity.linear[0] < 1e-3

    Args:
        source: path of a file, or name of a scene or graph in the package.
        scope: pytest scope of the fixture. All tests in one scope, such as a module, share a session; with `function`, each
            test has its own session.
        arguments: keyword arguments of `graphengine.load` and `Scene.session`.
    """
    import pytest

    scene, of_session = _loader(source, arguments)

    @pytest.fixture(scope=scope)
    def sim() -> Iterator[Session]:
        with scene().session(**of_session) as made:
            yield made

    return sim


def _loader(source: str | PathLike[str], arguments: dict[str, Any]) -> tuple[Callable[[], Scene], dict[str, Any]]:
    """Return a cached function that loads the scene, and the part of `arguments` that belongs to `Scene.session`."""
    from graphengine.api.scene_loading import load

    names = inspect.signature(load).parameters
    of_load = {name: value for name, value in arguments.items() if name in names}
    of_session = {name: value for name, value in arguments.items() if name not in names}
    return functools.cache(lambda: load(source, **of_load)), of_session
