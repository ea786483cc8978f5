"""Conveyor belts (`isaacsim.asset.gen.conveyor`)."""

from __future__ import annotations

from collections.abc import Iterable

from graphengine.devices.motion import Surface
from graphengine.format.errors import PhysicsError
from graphengine.node import BadValueError, Bound, Context, ExecIn, In, Node
from graphengine.node.types import Float, Float2, Float3, Target
from graphengine.nodes.checked import check_finite
from graphengine.nodes.touched import attribute_of

_NO_EFFECT = "no effect: textures do not move"


class IsaacConveyor(Node, type="isaacsim.asset.gen.conveyor.IsaacConveyor"):
    """Sets the surface velocity of a body, which carries along what lies on it and stays in place itself.

    The body is a body of the world or a link, fixed to the world or to another body; the surfaces of bodies that are attached to
    it move too. The velocity lasts until the next execution, or a reset. Every change takes effect, also one below 1 mm/s, which
    Isaac Sim ignores. A node whose `onStep` is not wired does nothing.
    """

    on_step = ExecIn(doc="sets the velocity; in Isaac Sim changes of inputs do that, too")
    enabled: bool = In(default=True, doc="false: executions do nothing, and the velocity stays as it is")
    conveyor_prim: Target = In(required=True, setup=True, doc="prim of the body")
    velocity: Float = In(default=0.0, unit="m/s, rad/s", doc="speed of the surface")
    direction: Float3 = In(
        default=(1.0, 0.0, 0.0), doc="direction in the body's frame, or axis of the rotation; multiplied by `velocity`"
    )
    curved: bool = In(
        default=False, doc="true: the surface turns about the origin of the body; false: it moves straight"
    )
    animate_texture: bool = In(default=False, doc=_NO_EFFECT)
    animate_scale: Float = In(default=1.0, doc=_NO_EFFECT)
    animate_direction: Float2 = In(default=(1.0, 0.0), doc=_NO_EFFECT)
    delta: Float = In(default=0.0, unit="s", doc=_NO_EFFECT)

    surface: Surface = Bound()

    def setup(self, context: Context) -> None:
        """Bind the body.

        Raises:
            ContextError: a joint moves the body.
        """
        self.surface = context.conveyor(self.conveyor_prim[0])

    def compute(self) -> None:
        """Set the velocity.

        Raises:
            BadValueError: the velocity is not finite or too large.
        """
        if not self.enabled:
            return
        check_finite(self, "velocity", "direction")
        x, y, z = (self.velocity * part for part in self.direction)
        still = (0.0, 0.0, 0.0)
        try:
            self.surface.move(*((still, (x, y, z)) if self.curved else ((x, y, z), still)))
        except PhysicsError as error:
            raise BadValueError("velocity, direction", [self.velocity, self.direction], str(error)) from error

    def writes(self) -> Iterable[str]:
        """The surface velocity of the body."""
        return [attribute_of(path, "physxSurfaceVelocity:surfaceVelocity") for path in self.conveyor_prim]
