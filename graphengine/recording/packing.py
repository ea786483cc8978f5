"""Packs a scene with files and load options, so that another process can load the scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

from graphengine.recording.manifest import RaysName
from graphengine.recording.sources import SourceNames, Workspace, read_again, sources
from graphengine.scene.loaded_scene import LoadedScene, Options

_CASTING = ("lidar", "radar", "range")
"""Kinds of devices that cast rays."""


@dataclass(frozen=True, slots=True)
class PackedScene:
    """A scene in a form that another process can load, without paths of this machine.

    Attributes:
        given: name of the given scene or graph file.
        scene: name of the scene into which a single graph is loaded; empty if there is none.
        options: load options without machine-dependent options such as folders; `rays` is the ray casting method in use.
        files: contents of all files, by name.
    """

    given: str
    scene: str
    options: Options
    files: Mapping[str, bytes]

    @classmethod
    def of(cls, scene: LoadedScene) -> PackedScene:
        """Return a packed scene; reads the files of the scene again.

        Raises:
            RecordingError: a file cannot be read again.
        """
        names, options = SourceNames(scene.files), scene.options
        files = read_again(scene.files, sources(scene.files, scene.definitions, names))
        bare = replace(options, allowed=(), installed=(), message_paths=(), shipped=None, scene=None)
        bare = replace(bare, registry=None, near=None, given=None)
        if scene.world is not None and any(any(scene.stage.prims(kind)) for kind in _CASTING):
            bare = replace(bare, rays=cast("RaysName", scene.world.simulation.rays.name))
        placed = names.name(options.scene.absolute()) if options.scene else ""
        return cls(names.name(scene.path.absolute()), placed, bare, files)

    def lay_out(self, workspace: Workspace) -> tuple[Path, Options]:
        """Write the files to a folder, and return the path of the scene there and the options to load the scene.

        Args:
            workspace: folder, which must exist as long as the scene is used.

        Raises:
            RecordingError: the files are too many or too large, or cannot be written.
        """
        for name, data in self.files.items():
            workspace.add(name, data)
        return workspace.path(self.given), workspace.options(self.options, self.scene)
