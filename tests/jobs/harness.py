"""The whole stack in this process: files, engine, physics and messages; only the wire is memory."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from graphengine.format.errors import NodeError
from graphengine.format.files import find_file
from graphengine.format.spec import RobotUse
from graphengine.messages import messages
from graphengine.messages.endpoints import EndpointClaim
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.runtime.commands import parse
from graphengine.runtime.entity_commands import Spawn
from graphengine.scene import build
from graphengine.scene.loaded_scene import BadValues, LoadedScene, Options

ROOT = Path(__file__).resolve().parents[2]


class Recorder:
    """Every message in the order in which it was sent."""

    def __init__(self) -> None:
        self.stream: list[tuple[str, str, bytes]] = []

    def write(self, claim: EndpointClaim, data: bytes) -> None:
        self.stream.append((claim.topic, claim.message_type, data))

    def deliver(self, claim: EndpointClaim, arrived: Sequence[bytes]) -> None:
        pass

    @property
    def digest(self) -> str:
        """A fingerprint of topics, types, bytes and their order."""
        made = hashlib.sha256()
        for topic, message_type, data in self.stream:
            made.update(f"{topic} {message_type} {len(data)} ".encode())
            made.update(data)
        return made.hexdigest()


class Job:
    """A running scene, and a peer on its network that can speak.

    Args:
        name: a file, or the name of a scene that ships.
        overrides: as `--set` gives them.
        seed: as `--seed` gives it.
        heard: whether the peer hears everything; if not, nobody listens until a reader is made.
        fault: hears of nodes that raise, as with `--keep-going`.
        bad_values: as `--bad-values` gives it.
        options: other fields of `Options`.
    """

    def __init__(
        self,
        name: str | Path,
        overrides: Mapping[str, Any] | None = None,
        *,
        seed: int = 0,
        heard: bool = True,
        fault: Callable[[NodeError], None] | None = None,
        bad_values: BadValues = "drop",
        **options: Any,
    ) -> None:
        self.transport = MemoryTransport(wants_all=heard)
        self.recorder = Recorder()
        self.scene = assemble(name, overrides, **options)
        network = LiveNetwork(lambda domain: self.transport, 0, lambda complaint: None)
        if heard:
            network.sinks.append(self.recorder)
        self.session = build.start(self.scene, network, seed=seed, fault=fault, bad_values=bad_values)

    def __enter__(self) -> Job:
        return self

    def __exit__(self, *_: object) -> None:
        self.session.close()

    @property
    def rate(self) -> float:
        """Ticks a second."""
        return 1.0 / self.session.clock.delta

    def spawn(self, name: str, use: RobotUse, *, force: bool = False) -> None:
        """Put a robot into the scene."""
        Spawn(name=name, use=use, force=force).apply(self.session)

    def remove(self, name: str) -> None:
        """Remove a robot."""
        self.ask("delete", name=name)

    def ask(self, name: str, /, **arguments: Any) -> None:
        """Carry out a command, with its arguments as JSON has them."""
        parse(name, arguments).apply(self.session)

    def run(self, seconds: float) -> None:
        """Let simulation time pass."""
        self.session.step(round(seconds * self.rate))

    def say(self, topic: str, v: float, w: float) -> None:
        """Command a velocity, once."""
        self.transport.inject(topic, twist(v, w))

    def drive(self, topic: str, v: float, w: float, seconds: float, every: int = 6) -> None:
        """Command a velocity again and again, every so many ticks."""
        for tick in range(round(seconds * self.rate)):
            if tick % every == 0:
                self.say(topic, v, w)
            self.session.step()

    def heard(self, topic: str) -> list[Any]:
        """All messages of a topic, oldest first."""
        return self.transport.messages(topic)

    def newest(self, topic: str) -> Any:
        """The last message of a topic."""
        return messages.decode(self.transport.raw(topic)[-1], self.types()[topic])

    def types(self) -> dict[str, str]:
        """Type of each topic that something was sent on."""
        return {topic: message_type for topic, message_type, _ in self.recorder.stream}

    def velocity(self, topic: str) -> tuple[float, float]:
        """Forward speed and yaw rate of the newest odometry."""
        moving = self.newest(topic).twist.twist
        return moving.linear.x, moving.angular.z


_shipped: dict[object, LoadedScene] = {}


def assemble(name: str | Path, overrides: Mapping[str, Any] | None = None, **options: Any) -> LoadedScene:
    """A scene, loaded; one that ships is loaded once in a process, as no session changes it."""
    given = Options(overrides or {}, **options)
    if isinstance(name, Path) or given.registry is not None or given.allowed:
        return build.load(name if isinstance(name, Path) else find_file(name).absolute(), given)
    key = name, repr(given)
    if key not in _shipped:
        _shipped[key] = build.load(find_file(name).absolute(), given)
    return _shipped[key]


def twist(v: float, w: float) -> Any:
    return messages.Twist(messages.Vector3(v, 0.0, 0.0), messages.Vector3(0.0, 0.0, w))


def nanoseconds(time: Any) -> int:
    """A stamp as a whole number."""
    return int(time.sec) * 1_000_000_000 + int(time.nanosec)


def yaw(rotation: Any) -> float:
    """Angle about the vertical of a level robot."""
    return 2.0 * math.atan2(rotation.z, rotation.w)


def tick_times(ticks: Sequence[int], rate: int) -> list[int]:
    """Nanoseconds at which ticks are, by whole numbers."""
    return [tick * 1_000_000_000 // rate for tick in ticks]
