"""The manifest of a recording: the arguments and the environment of the run."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal, Self, cast

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from graphengine.format import bounded_json
from graphengine.format.errors import RecordingError
from graphengine.messages.distros import JAZZY, Distro
from graphengine.recording import platform_info
from graphengine.recording.sources import SourceNames
from graphengine.runtime.session_core import SessionCore
from graphengine.scene.loaded_scene import BadValues, LoadedScene

FORMAT = 1
MAX_BYTES = 16_000_000
"""Maximum size of one entry of the metadata, bytes; the overrides of a run can be long."""
RaysName = Literal["auto", "mujoco", "fast"]
Positive = Annotated[int, Field(ge=1)]
DomainId = Annotated[int, Field(ge=0, le=232)]


class Manifest(BaseModel):
    """The options, the platform and the names of the main files of a recorded run."""

    model_config = ConfigDict(frozen=True)

    given: str
    """Name of the scene or graph that was run."""
    scene: str = ""
    """Name of the scene into which a single graph was loaded; empty if none was given."""
    overrides: dict[str, Any] = {}
    seed: int = 0
    robot_state: bool = False
    localization: Literal["truth"] | None = None
    distro: Distro = JAZZY
    """ROS 2 distribution of the message types; recordings without this entry used Jazzy."""
    rays: RaysName = "auto"
    """Method of ray casting for lidars."""
    keep_going: bool = False
    bad_values: BadValues = "stop"
    """Reaction to a value that a node cannot use. In a recording without this entry, the run stopped."""
    drops_set_values: bool = False
    """Whether `drop` also dropped values that were set while the session ran. In a recording without this entry, it did not."""
    sees_own_robots: bool = False
    """Whether ray sensors saw their own robot if the robot file does not say so. Without this entry, they did not."""
    modules: tuple[Annotated[str, Field(pattern=r"^\w+(\.\w+)*$")], ...] = ()
    """Additional Python modules with node types. A replay needs the same modules."""
    domain_id: DomainId = 0
    domain_from_environment: DomainId | None = None
    identity: Annotated[str, Field(pattern=r"^([0-9a-f]{2}){0,64}$")] = ""
    """Identity of the session on its network, in hexadecimal; UUIDs of action goals depend on it."""
    period: tuple[Positive, Positive]
    """Seconds between two ticks as numerator and denominator."""
    machine: dict[str, str] = {}

    def metadata(self) -> dict[str, str]:
        """Return the manifest as MCAP metadata: JSON text by key."""
        return {"format": str(FORMAT)} | {key: json.dumps(value) for key, value in self.model_dump().items()}

    @classmethod
    def from_metadata(cls, metadata: Mapping[str, str]) -> Self:
        """Return the manifest read from MCAP metadata.

        Raises:
            RecordingError: the metadata is not a manifest, or the manifest has another format version.
        """
        written = metadata.get("format", "")
        if written != str(FORMAT):
            raise RecordingError(f"it has format {written[:20]!r}; this version reads {FORMAT}")
        try:
            entries = {key: text for key, text in metadata.items() if key != "format"}
            return cls(**{key: bounded_json.parse(text, MAX_BYTES) for key, text in entries.items()})
        except ValidationError as error:
            first = error.errors()[0]
            raise RecordingError(f"its {'.'.join(map(str, first['loc']))} is invalid: {first['msg']}") from None
        except ValueError as error:
            raise RecordingError(f"its metadata on the run cannot be read: {error}") from None


def describe_run(
    scene: LoadedScene, session: SessionCore, names: SourceNames, keep_going: bool, modules: Sequence[str]
) -> Manifest:
    """Return the manifest of a session whose nodes are set up.

    Args:
        scene: scene of the session.
        session: the session.
        names: machine-independent names of the files that were read.
        keep_going: whether the session continues when a node raises an exception.
        modules: additional Python modules with node types.
    """
    options, services = scene.options, session.services
    return Manifest(
        given=names.name(scene.path.absolute()),
        scene=names.name(options.scene.absolute()) if options.scene else "",
        overrides=dict(options.overrides),
        seed=services.seed,
        robot_state=options.robot_state,
        localization=options.localization,
        distro=scene.definitions.distro,
        rays=cast(RaysName, services.world.rays_in_use or options.rays),
        keep_going=keep_going,
        bad_values="drop" if services.dropped is not None else "stop",
        drops_set_values=services.dropped is not None,
        sees_own_robots=options.sees_own_robots,
        modules=tuple(modules),
        domain_id=services.domain_id,
        domain_from_environment=services.domain_from_environment,
        identity=services.network.identity.hex(),
        period=services.world.tick_period,
        machine=platform_info.describe(scene, session),
    )
