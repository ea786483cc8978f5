"""Gymnasium environments of scenes, with the extra `gym`. After `import graphengine as ge`, write `ge.gym.SceneEnv(…)`."""

from __future__ import annotations

from graphengine.api.gym.actuations import BaseVelocity, JointTargets
from graphengine.api.gym.observations import Observation
from graphengine.format.distribution import install_command
from graphengine.format.errors import UsageError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from graphengine.api.gym.scene_env import SceneEnv, make_vec

__all__ = ["SceneEnv", "make_vec", "Observation", "BaseVelocity", "JointTargets"]

if not TYPE_CHECKING:  # so that a misspelt name is an error to mypy and pyright

    def __getattr__(name: str) -> object:
        """Import gymnasium when a name that needs it is first used, and return the object of the name."""
        if name not in __all__:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        try:
            from graphengine.api.gym import scene_env
        except ModuleNotFoundError as error:
            raise UsageError(f"ge.gym.{name} needs {error.name}\n  {install_command('gym')}") from error
        return getattr(scene_env, name)
