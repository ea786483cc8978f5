"""The conveyor belt node of `isaacsim.asset.gen.conveyor`."""

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
    """Sets the surface velocity of a body. The surface carries along the objects on it, while the body itself stays in place.

    The body must belong to the world or be a link of a robot, and no joint may move it. Bodies that are fixed to the
    conveyor's body get the same surface velocity. The velocity lasts until the next execution or reset. Isaac Sim ignores changes
    below 1 mm/s; in graphengine, they take effect. Without a wire to `onStep`, the node does nothing.
    """

    on_step = ExecIn(doc="sets the surface velocity; in Isaac Sim, a change of an input sets it too")
    enabled: bool = In(default=True, doc="false: executions do nothing, and the surface keeps its velocity")
    conveyor_prim: Target = In(required=True, setup=True, doc="prim of the conveyor's body")
    velocity: Float = In(default=0.0, unit="m/s, rad/s", doc="speed of the surface")
    direction: Float3 = In(
        default=(1.0, 0.0, 0.0),
        doc="direction of motion, or rotation axis if `curved` is true, in the body's frame; its length multiplies `velocity`",
    )
    curved: bool = In(default=False, doc="true: the surface turns about the body's origin; false: it moves straight")
    animate_texture: bool = In(default=False, doc=_NO_EFFECT)
    animate_scale: Float = In(default=1.0, doc=_NO_EFFECT)
    animate_direction: Float2 = In(default=(1.0, 0.0), doc=_NO_EFFECT)
    delta: Float = In(default=0.0, unit="s", doc=_NO_EFFECT)

    surface: Surface = Bound()

    def setup(self, context: Context) -> None:
        """Look up the body at `conveyorPrim` and keep a handle to its surface velocity.

        Raises:
            ContextError: the prim does not exist, has no body, or a joint moves the body.
        """
        self.surface = context.conveyor(self.conveyor_prim[0])

    def compute(self) -> None:
        """Set the surface velocity, unless `enabled` is false.

        Raises:
            BadValueError: the velocity is not finite or is too large for the physics.
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
        """Return the resource key of the body's surface velocity."""
        return [attribute_of(path, "physxSurfaceVelocity:surfaceVelocity") for path in self.conveyor_prim]
