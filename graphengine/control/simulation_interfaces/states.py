"""Handles requests for simulation states, single steps and resets."""

from __future__ import annotations

from typing import Any

from graphengine.control.simulation_interfaces.results import FAILED, RefusedError
from graphengine.format.errors import GraphError, RecordingError
from graphengine.runtime.command import Command
from graphengine.runtime.commands import MAX_TICKS, Pause, Play, Quit, Reset, Scope, Step, Stop
from graphengine.runtime.session_core import SessionCore

STOPPED, PLAYING, PAUSED, QUITTING = range(4)
_STATES = {"stopped": STOPPED, "playing": PLAYING, "paused": PAUSED, "failed": PAUSED}
"""Code in SimulationState of each state of a session; `failed` has no code and is reported as paused."""
_COMMANDS: dict[int, type[Command]] = {STOPPED: Stop, PLAYING: Play, PAUSED: Pause, QUITTING: Stop}
_ALREADY, _TRANSITION_FAILED, _INCORRECT_TRANSITION = 101, 102, 103
_SCOPES: dict[int, Scope] = {1: "time", 2: "state", 4: "spawned"}


def get_state(session: SessionCore, request: Any, response: Any) -> None:
    """Answer GetSimulationState; a failed session is reported as paused."""
    response.state.state = _STATES[session.state]


def set_state(session: SessionCore, request: Any, response: Any) -> None:
    """Answer SetSimulationState: stop, play, pause or quit; quitting stops the simulation and then ends the run."""
    target = request.state.state
    if target == _STATES[session.state]:
        raise RefusedError(_ALREADY, f"the simulation is {session.state} already")
    if target not in _COMMANDS:
        raise RefusedError(_INCORRECT_TRANSITION, f"unknown state {target}; legal: 0 to 3")
    if (session.state, target) == ("stopped", PAUSED):
        raise RefusedError(_INCORRECT_TRANSITION, "a stopped simulation cannot pause; it can play or quit")
    try:
        _COMMANDS[target]().apply(session)
    except RecordingError:
        raise
    except GraphError as error:
        raise RefusedError(_TRANSITION_FAILED, str(error)) from error
    if target == QUITTING:
        Quit().apply(session)


def reset(session: SessionCore, request: Any, response: Any) -> None:
    """Answer ResetSimulation: each bit of the request selects a scope to reset; 0 selects all scopes."""
    wanted = [scope for bit, scope in _SCOPES.items() if request.scope & bit]
    if request.scope and not wanted:
        legal = "legal: 1 (time), 2 (state), 4 (spawned), and their sums"
        raise RefusedError(FAILED, f"unknown scope {request.scope}; {legal}")
    Reset(scope=tuple(wanted) or ("all",)).apply(session)


def step(session: SessionCore, request: Any, response: Any) -> None:
    """Answer StepSimulation: run a number of ticks of a paused simulation, which then pauses again."""
    run_steps(session, request.steps)


def run_steps(session: SessionCore, count: int) -> None:
    """Run a number of ticks of a paused session.

    Raises:
        RefusedError: the number of ticks is out of range, or the session is not paused.
    """
    if not 0 < count <= MAX_TICKS:
        raise RefusedError(FAILED, f"cannot run {count} steps; legal: 1 to {MAX_TICKS}")
    if session.state != "paused":
        raise RefusedError(FAILED, f"the simulation is {session.state}; pause it before running single steps")
    Step(ticks=count).apply(session)
