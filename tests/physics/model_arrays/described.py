"""All descriptions whose models are compared, and the model of each as a scene has it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import mujoco
import numpy as np

from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files, find_file
from graphengine.format.scene_spec import SceneSpec
from graphengine.format.spec_reader import read
from graphengine.physics.loading import load_world
from tests.physics.harness import FLOOR
from tests.physics.model_arrays import generator, look_alikes
from tests.physics.model_arrays.figures import digest

Format = Literal["urdf", "mjcf", "sdf"]
BOTH = """scene: s
world: world.xml
robots:
  bare: {{use: {0}, position: [0, 0, 2]}}
  filed: {{use: bot.yaml, position: [5, 0, 2], orientation: {{rpy_deg: [0, 0, 30]}}}}
"""
"""A scene with a robot by its description alone and by its robot file."""
WORLD_ONLY = "scene: s\nworld: world.sdf\n"


@dataclass(frozen=True)
class Described:
    """A scene with descriptions.

    Attributes:
        name: unique.
        format: of the descriptions.
        files: contents by path.
        scene: text of the scene file; empty if the scene ships under this name.
    """

    name: str
    format: Format
    files: look_alikes.Files
    scene: str = ""


def all_described() -> Iterator[Described]:
    """Yield all descriptions in a fixed order."""
    for seed in range(generator.COUNT):
        yield Described(f"seed {seed}", "urdf", generator.files(seed), BOTH.format("bot.urdf"))
    for name, files in look_alikes.of_urdf():
        yield Described(name, "urdf", files, BOTH.format(min(files)))
    for name, files in look_alikes.of_mjcf():
        yield Described(name, "mjcf", files, BOTH.format("bot.xml"))
    for name, files in look_alikes.of_sdf():
        yield Described(name, "sdf", files, BOTH.format("bot.sdf"))
    world: look_alikes.Files = {"world.sdf": look_alikes.WORLD_SDF, **look_alikes.WORLD_FILES}
    yield Described("sdf world", "sdf", world, WORLD_ONLY)
    yield Described("fleet of several robots", "urdf", look_alikes.FLEET_FILES, look_alikes.FLEET)
    for name in look_alikes.SHIPPED:
        yield Described(name, "urdf", {})


def model_of(described: Described, folder: Path) -> mujoco.MjModel:
    """Return the model of a scene; its files are written to a folder."""
    if not described.scene:
        return load(find_file(described.name).absolute())
    for name, content in {"world.xml": FLOOR, **described.files, "scene.yaml": described.scene}.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return load(folder / "scene.yaml")


def source_of(described: Described) -> str:
    """Return a digest of the files of a description; empty for a scene that ships."""
    files = sorted({**described.files, "scene.yaml": described.scene}.items()) if described.scene else []
    texts = [name.encode() + (content if isinstance(content, bytes) else content.encode()) for name, content in files]
    return digest(np.frombuffer(b"".join(texts), np.uint8)) if texts else ""


def load(path: Path, *allowed: Path) -> mujoco.MjModel:
    """Return the model with which a scene starts. The scene does not settle, as this changes no model and takes seconds.

    Args:
        path: path of the scene file.
        allowed: folders outside of the scene's own in which files may be read.
    """
    findings = Findings()
    scene = read(SceneSpec, path, findings)
    if scene is not None:
        scene = replace(scene, spec=scene.spec.model_copy(update={"settle": False}))
    loaded = load_world(scene, Files.of(path, allowed), findings) if scene is not None else None
    if loaded is None:
        raise ValueError("\n".join(finding.render() for finding in findings.errors))
    return loaded.simulation.model
