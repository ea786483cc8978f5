"""The files of a scene, packed so that another process or machine can load the scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from graphengine.api.scene import Scene, loaded_of
from graphengine.api.scene_loading import open_scene
from graphengine.api.values import plain
from graphengine.recording.packing import PackedScene
from graphengine.recording.sources import PROJECT, SHIPPED, Workspace
from graphengine.scene.loaded_scene import Options


@dataclass(frozen=True, slots=True)
class UnpackedScene:
    """The unpacked files of a scene in a folder, with the options that load it."""

    path: Path
    options: Options

    def load(self, settings: Mapping[str, Any], *, allow_scripts: bool) -> Scene:
        """Load the scene; `settings` sets input values by address.

        Raises:
            CheckError: the scene has errors.
        """
        return open_scene(self.path, replace(self.options, overrides=plain(settings), scripts=allow_scripts))


@dataclass(frozen=True, slots=True)
class SceneFiles:
    """The contents of all files that a scene reads."""

    packed: PackedScene
    origins: Mapping[str, str]
    """Original folder of the files in each unpacked folder, in the order in which `original` replaces them."""

    @classmethod
    def of(cls, scene: Scene) -> SceneFiles:
        """Return the files of a scene.

        Raises:
            RecordingError: a file cannot be read again.
        """
        loaded = loaded_of(scene)
        packed = PackedScene.of(loaded)
        own = str(loaded.path.resolve()).removesuffix(packed.given.partition("/")[2])
        return cls(packed, {f"{{}}/{PROJECT}/": own, f"{{}}/{SHIPPED}/": f"{loaded.files.base}/", f"{Path.cwd()}/": ""})

    @property
    def contents(self) -> Sequence[bytes]:
        """Contents of the files."""
        return [*self.packed.files.values()]

    def unpack(self, folder: Path) -> UnpackedScene:
        """Write the files to an empty folder, which must exist as long as the scene is used.

        Raises:
            RecordingError: the files are too many or too large, or cannot be written.
        """
        return UnpackedScene(*self.packed.lay_out(Workspace(folder)))

    def original(self, text: str, folder: Path) -> str:
        """Return a text in which the paths of files unpacked to a folder are replaced by the original paths."""
        for place, origin in self.origins.items():
            text = text.replace(place.format(folder), origin)
        return text
