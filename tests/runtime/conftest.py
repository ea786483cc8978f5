"""`play` makes a session."""

from __future__ import annotations

from tests.compiler.conftest import play as play
