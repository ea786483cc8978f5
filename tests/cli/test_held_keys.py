"""Keys of a run's terminal: pressed when they come, let go when they no longer do, and the terminal as it was afterwards."""

from __future__ import annotations

import os
import pty
import sys
import termios
from collections.abc import Iterator, Mapping
from typing import Any

import pytest

from graphengine.cli import held_keys
from graphengine.cli.held_keys import RELEASE_AFTER, HeldTerminalKeys
from graphengine.format.errors import UsageError
from graphengine.runtime.inbox import ExternalInputs
from graphengine.runtime.session_core import SessionCore
from tests.compiler.harness import Play


class Told(ExternalInputs):
    """Remembers the keys that a session was told of."""

    def __init__(self) -> None:
        self.told: list[tuple[str, ...]] = []

    def command(self, name: str, arguments: Mapping[str, Any]) -> None:
        self.told.append((name, *arguments["keys"]))


def listened() -> tuple[SessionCore, list[tuple[str, ...]]]:
    """A session, and the keys that it is told of."""
    session = Play().session
    session.inbox = inbox = Told()
    return session, inbox.told


class Terminal:
    """A terminal on which a test types, at times that the test says."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.keyboard, self.screen = pty.openpty()
        self.now = 100.0
        self.stdin = os.fdopen(self.screen, closefd=False)
        monkeypatch.setattr(sys, "stdin", self.stdin)
        monkeypatch.setattr(held_keys, "monotonic", lambda: self.now)

    def type(self, text: str) -> None:
        os.write(self.keyboard, text.encode())

    def close(self) -> None:
        self.stdin.close()
        os.close(self.keyboard)
        os.close(self.screen)


@pytest.fixture
def terminal(monkeypatch: pytest.MonkeyPatch) -> Iterator[Terminal]:
    made = Terminal(monkeypatch)
    yield made
    made.close()


def test_a_key_is_held_as_long_as_it_is_repeated(terminal: Terminal) -> None:
    session, told = listened()
    with HeldTerminalKeys() as keys:
        for _ in range(4):
            terminal.type("w")
            keys.on_tick(session)
            terminal.now += 0.9 * RELEASE_AFTER
        assert told == [("press", "W")]
        terminal.now += 0.2 * RELEASE_AFTER
        keys.on_tick(session)
    assert told == [("press", "W"), ("release", "W")]


def test_a_key_of_two_characters_is_released_after_both(terminal: Terminal) -> None:
    session, told = listened()
    with HeldTerminalKeys() as keys:
        terminal.type("W")
        keys.on_tick(session)
        terminal.now += 0.9 * RELEASE_AFTER
        terminal.type("A")
        keys.on_tick(session)
        terminal.now += 0.2 * RELEASE_AFTER
        keys.on_tick(session)
        assert told[2:] == [("release", "W")]
        terminal.now += RELEASE_AFTER
        keys.on_tick(session)
    assert told[3:] == [("release", "LeftShift", "A")]


def test_a_key_of_another_held_character_is_not_released(terminal: Terminal) -> None:
    session, told = listened()
    with HeldTerminalKeys() as keys:
        terminal.type("w")
        keys.on_tick(session)
        terminal.now += 0.9 * RELEASE_AFTER
        terminal.type("W")
        keys.on_tick(session)
        terminal.now += 0.2 * RELEASE_AFTER
        keys.on_tick(session)
    assert told == [("press", "W"), ("press", "LeftShift", "W")]


def test_characters_without_a_key_name_have_no_effect(terminal: Terminal) -> None:
    session, told = listened()
    with HeldTerminalKeys() as keys:
        terminal.type("ß€\x00")
        keys.on_tick(session)
    assert told == []


def test_the_terminal_settings_are_restored_and_ctrl_c_still_interrupts(terminal: Terminal) -> None:
    before = termios.tcgetattr(terminal.screen)
    with HeldTerminalKeys():
        during = termios.tcgetattr(terminal.screen)[3]
        assert not during & (termios.ECHO | termios.ICANON)
        assert during & termios.ISIG
    assert termios.tcgetattr(terminal.screen) == before


def test_without_a_terminal_keys_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    with open(os.devnull) as nothing:
        monkeypatch.setattr(sys, "stdin", nothing)
        with pytest.raises(UsageError, match="the standard input is not one"):
            HeldTerminalKeys()
