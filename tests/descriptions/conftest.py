"""The fixtures of `tests/physics`: a description is compiled where its meaning shows only then."""

from tests.physics.conftest import project as project
from tests.physics.conftest import ship as ship
