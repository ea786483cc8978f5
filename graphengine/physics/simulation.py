"""One MuJoCo model and its state, behind `backend.World`."""

from __future__ import annotations

from functools import cached_property
from typing import Any, TypeVar

from graphengine.devices.stage import Prim, PrimKind
from graphengine.physics.core import SimulationCore
from graphengine.physics.dynamics.entities import Entities
from graphengine.physics.dynamics.handle_table import Handle
from graphengine.physics.dynamics.handles import CarriedPrim, Joints
from graphengine.physics.dynamics.placing import PlacedBody, find_mover
from graphengine.physics.pictures.render_thread import RenderThread
from graphengine.physics.sensors.camera import PinholeCamera, native_size
from graphengine.physics.sensors.contact import BodyContactSensor
from graphengine.physics.sensors.imu import InertialUnit
from graphengine.physics.sensors.lidar import RayLidar

H = TypeVar("H", bound=Handle)


class Simulation(SimulationCore):
    """Physics and sensors of a scene: what nodes hold of it, by prim; arguments and errors are those of its core."""

    @cached_property
    def studio(self) -> RenderThread:
        """What draws its cameras' pictures."""
        return RenderThread(self)

    def picture_driver(self) -> str:
        """Name and version of the OpenGL driver; `not there` where there is none."""
        return self.studio.driver()

    @cached_property
    def entities(self) -> Entities:
        """Its robots and objects as wholes."""
        return Entities(self, self.body)

    def save(self) -> Any:
        """A copy of the present state; pictures that are being drawn are waited for."""
        return super().save(), self.studio.save()

    def restore(self, saved: Any) -> None:
        """Go back to what `save` returned, while the same robots were there."""
        state, studio = saved
        super().restore(state)
        self.studio.restore(studio)

    def close(self) -> None:
        """Forget the handles, and end what draws for them."""
        super().close()
        self.studio.close()

    def body(self, prim: Prim) -> CarriedPrim:
        """The rigid body at, or carrying, a prim."""
        return self._handle(CarriedPrim, prim)

    def frame(self, prim: Prim) -> CarriedPrim:
        """The pose of a prim."""
        return self._handle(CarriedPrim, prim)

    def mass(self, prim: Prim) -> float:
        """Mass of the body that a prim has of its own, kg."""
        assert prim.body is not None
        return float(self.model.body(prim.body).mass[0])

    def placement(self, prim: Prim) -> PlacedBody | None:
        """What puts a prim's body somewhere and holds it there; None where nothing can move it, or only with another body."""
        return self._handle(PlacedBody, prim) if find_mover(self.model, self.stage, prim) is not None else None

    def articulation(self, robot: Prim) -> Joints:
        """The joints of a robot prim."""
        return self._handle(Joints, robot, "robot")

    def lidar(self, prim: Prim) -> RayLidar:
        """The ray-casting sensor at a lidar prim."""
        return self._handle(RayLidar, prim, "lidar")

    def camera(self, prim: Prim, size: tuple[int, int] | None = None) -> PinholeCamera:
        """The camera at a camera prim, with pictures of a size, or of its own."""
        self._expect(prim, "camera")
        width, height = size or native_size(prim)
        place = f"{prim.path}/{width}x{height}"
        return self._handles.find(PinholeCamera, place, lambda: PinholeCamera(self, self.studio, prim, (width, height)))

    def imu(self, prim: Prim) -> InertialUnit:
        """The inertial unit at an imu prim."""
        return self._handle(InertialUnit, prim, "imu")

    def contact_sensor(self, prim: Prim) -> BodyContactSensor:
        """The contact sensor at a contact prim."""
        return self._handle(BodyContactSensor, prim, "contact")

    def _handle(self, make: type[H], prim: Prim, kind: PrimKind | None = None) -> H:
        if kind is not None:
            self._expect(prim, kind)
        return self._handles.find(make, prim.path, lambda: make(self, prim))
