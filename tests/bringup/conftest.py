"""`ship` loads a scene that ships."""

from __future__ import annotations

from tests.physics.conftest import ship as ship
