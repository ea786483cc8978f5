"""Sessions for tests of graphs and scenes."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Iterator
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from graphengine.api.scene import Scene
    from graphengine.api.session import Session

FixtureScope = Literal["function", "class", "module", "package", "session"]


def session(source: str | PathLike[str], **arguments: Any) -> Session:
    """Start a session of a scene or graph, for a `with` statement.

        with session("dd100_flat", set={"DiffController.maxLinearSpeed": 0.5}, seed=1) as sim:
            sim.step()

    Args:
        source: path of a file, or name of an included scene or graph.
        arguments: keyword arguments of `graphengine.load` and `Scene.session`.

    Raises:
        CheckError: the files have errors.
    """
    of_load, of_session = _divided(arguments)
    return _load(source, of_load).session(**of_session)


def session_fixture(
    source: str | PathLike[str],
    *,
    scope: Literal["function", "class", "module", "package", "session"] = "function",
    **arguments: Any,
) -> Any:
    """A pytest fixture that gives each test a session, closed at its end; the scene is loaded once.

        sim = session_fixture("dd100_flat", seed=1)

        def test_a_robot_at_rest_stays(sim):
            assert sim.run(1.0) and sim.robots["dd100"].velocity.linear[0] < 1e-3

    Args:
        source: path of a file, or name of an included scene or graph.
        scope: pytest scope of the fixture.
        arguments: keyword arguments of `graphengine.load` and `Scene.session`.
    """
    import pytest

    of_load, of_session = _divided(arguments)
    scene = functools.cache(lambda: _load(source, of_load))

    @pytest.fixture(scope=scope)
    def sim() -> Iterator[Session]:
        with scene().session(**of_session) as made:
            yield made

    return sim


def _divided(arguments: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Split keyword arguments into those of `load` and those of `Scene.session`."""
    from graphengine.api.loading import load

    names = inspect.signature(load).parameters
    return (
        {name: value for name, value in arguments.items() if name in names},
        {name: value for name, value in arguments.items() if name not in names},
    )


def _load(source: str | PathLike[str], arguments: dict[str, Any]) -> Scene:
    from graphengine.api.loading import load

    return load(source, **arguments)
