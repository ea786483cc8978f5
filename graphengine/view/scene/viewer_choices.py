"""What one viewer of the page chooses for its picture: the selected entity, the shown layers and the camera."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, get_args

View = Literal["free", "follow", "chase", "top", "robot"]
"""Where a camera is: where the viewer turns it, around the selection, behind it, above it, or in the camera of the robot."""
DEFAULT_LAYERS = frozenset(("robots", "objects", "world", "lidar"))
"""Names of the layers that are shown until a viewer chooses others."""


@dataclass(slots=True)
class ViewerChoices:
    """The choices of one viewer.

    Attributes:
        selected: name of the selected robot or object; empty if none is selected.
        layers: names of the shown layers.
        view: where the camera is.
        moves: whether handles move the selected entity.
    """

    selected: str = ""
    layers: frozenset[str] = DEFAULT_LAYERS
    view: View = "follow"
    moves: bool = False

    def choose(self, asked: Mapping[str, Any]) -> None:
        """Take the choices in a viewer's request; choices with illegal values stay as they are."""
        if isinstance(asked.get("layers"), list):
            self.layers = frozenset(name for name in asked["layers"] if isinstance(name, str))
        if asked.get("view") in get_args(View):
            self.view = asked["view"]
        if isinstance(asked.get("moves"), bool):
            self.moves = asked["moves"]
