"""Reads and checks scene and graph files, and returns them as a `Scene`."""

from __future__ import annotations

import copyreg
import os
import tempfile
import weakref
from collections.abc import Mapping, Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import TYPE_CHECKING, Any, Literal

from graphengine.api.scene import Scene, loaded_of
from graphengine.api.values import check_choice, plain
from graphengine.format.errors import UsageError
from graphengine.format.files import find_file, installed_packages
from graphengine.format.given_text import GivenText
from graphengine.format.wording import shown
from graphengine.scene import build
from graphengine.scene.loaded_scene import Options
from graphengine.scene.node_modules import make_registry

if TYPE_CHECKING:
    from graphengine.physics.ray_casting.rays import RaysChoice
    from graphengine.recording.packing import PackedScene

RAYS = ("auto", "mujoco", "fast")
NOTHING: Mapping[str, Any] = MappingProxyType({})


def load(
    source: str | PathLike[str] | Mapping[str, Any] | None = None,
    *,
    text: str | None = None,
    folder: str | PathLike[str] | None = None,
    set: Mapping[str, Any] = NOTHING,
    scene: str | PathLike[str] | None = None,
    robot_state: bool = False,
    localization: Literal["truth"] | None = None,
    rays: RaysChoice = "auto",
    allow: Sequence[str | PathLike[str]] = (),
    message_paths: Sequence[str | PathLike[str]] = (),
    packages: Sequence[str | PathLike[str]] = (),
    modules: Sequence[str | ModuleType] = (),
    env: Mapping[str, str] = NOTHING,
    allow_scripts: bool = False,
) -> Scene:
    """Read and check a scene or a graph; return it as a Scene.

    >>> scene = ge.load("dd100_flat", set={"DiffController.maxLinearSpeed": 0.8})
    >>> list(scene.robots)
    ['dd100']

    A scene or graph can also be a mapping or a YAML text, with the same keys and checks as a file. A finding then names `<dict>`
    with the path of the key, such as `<dict>: robots.bot.use`, or `<text>` with line and column. Recordings and pickled scenes
    contain the text; `Session.reload` reads only the files to which the text refers again.

    >>> robots = {f"bot_{y}": {"use": "robots/dd100.yaml", "position": [0, y, 0.025], "namespace": f"n{y}"} for y in (1, 2)}
    >>> list(ge.load({"scene": "rows", "world": "worlds/flat_grid.xml", "robots": robots}).robots)
    ['bot_1', 'bot_2']
    >>> list(ge.load(text="{graph: g, nodes: {Tick: OnPlaybackTick}}").graphs)
    ['g']

    Args:
        source: path of a file, or name of a scene or graph in the package, such as `dd100_warehouse` or `dd100/cmd_vel`; or the
            content of a file as a mapping. None if `text` is given.
        text: content of a file as YAML text, in place of `source`.
        folder: folder from which relative paths in a mapping or text start; None is the working directory.
        set: input values by address `[robot/][graph/]Node.port`; each part can be a glob pattern.
        scene: scene in which to run the graph `source`; None if `source` is a scene or needs no scene.
        robot_state: whether to publish the topics of robot_state_publisher for every robot.
        localization: `truth` publishes, for every mobile robot, the transform map -> odom on tf, computed from the robot's
            true pose; None publishes no such transform.
        rays: ray casting method of lidars: `mujoco`, `fast` (needs numba) or `auto`. `auto` takes `fast` if numba works and
            `fast` supports all shapes of the model, otherwise `mujoco`.
        allow: folders from which files can be read, in addition to the folder of the source.
        message_paths: paths of message definitions: ROS packages, folders of packages, or single files.
        packages: `share` folders of ROS packages, in addition to those in AMENT_PREFIX_PATH.
        modules: Python modules with node types, or names of such modules.
        env: values of the environment variables that graphs are allowed to read, by name.
        allow_scripts: whether graphs are allowed to run the Python code of their ScriptNodes; it runs without a sandbox.

    Raises:
        CheckError: the files have errors; the attribute `findings` has all errors, warnings and notes.
        UsageError: an argument is invalid, such as a missing file or a `set` address that matches no input.
    """
    path, given = _source(source, text, folder)
    check_choice("rays", rays, RAYS)
    if localization is not None:
        check_choice("localization", localization, ["truth"])
    folders = {"allow": allow, "message_paths": message_paths, "packages": packages}
    for name, several in {**folders, "modules": modules}.items():
        if isinstance(several, str):
            raise UsageError(f"{name}: expected a list, got {shown(several)}")
    paths = {name: [Path(path) for path in entries] for name, entries in folders.items()}
    for name, entries in paths.items():
        for place in entries:
            legal = "folder or file" if name == "message_paths" else "folder"
            if not place.is_dir() and not (place.is_file() and "file" in legal):
                raise UsageError(f"{name}: there is no {legal} {place}")
    options = Options(
        overrides=plain(set),
        allowed=paths["allow"],
        installed=[*paths["packages"], *installed_packages()],
        message_paths=paths["message_paths"],
        robot_state=robot_state,
        localization=localization,
        scene=find_file(str(scene)) if scene is not None else None,
        rays=rays,
        registry=make_registry(modules) if modules else None,
        near=Path.cwd(),
        environment=dict(env),
        scripts=allow_scripts,
        given=given,
    )
    names = [module if isinstance(module, str) else module.__name__ for module in modules]
    return open_scene(path, options, names)


def _source(
    source: str | PathLike[str] | Mapping[str, Any] | None, text: str | None, folder: str | PathLike[str] | None
) -> tuple[Path, GivenText | None]:
    """Return the path of the file to load, or the path that stands for a given text, and the text."""
    if (source is None) == (text is None):
        raise UsageError("load: give either a file, a mapping, or `text`")
    given = GivenText.of_text(text) if text is not None else None
    if isinstance(source, Mapping):
        given = GivenText.of_mapping(plain(source))
    if given is None:
        if folder is not None:
            raise UsageError("folder: only with a mapping or `text`; paths in a file start from the folder of the file")
        return find_file(str(source)), None
    if not os.path.isdir(folder or "."):
        raise UsageError(f"folder: there is no folder {os.fspath(folder or '.')}")
    return Path(folder or ".", given.label), given


def open_scene(path: Path, options: Options, modules: Sequence[str] = (), *, graphs: bool = True) -> Scene:
    """Read and check the scene in a file and return it; if `graphs` is False, its graphs are not loaded.

    Raises:
        CheckError: the scene has errors.
    """
    loaded = (build.load if graphs else build.load_without_graphs)(path, options)
    loaded.findings.raise_errors()
    return Scene(loaded, modules)


def _reduced(scene: Scene) -> tuple[Any, ...]:
    """Return the data to pickle: the scene's files, the load options and the names of the modules with node classes."""
    from graphengine.recording.packing import PackedScene

    return unpack, (PackedScene.of(loaded_of(scene)), scene._modules)


copyreg.pickle(Scene, _reduced)


def unpack(packed: PackedScene, modules: Sequence[str]) -> Scene:
    """Restore a pickled scene and return it.

    The scene's files are written to a temporary folder, which exists until the scene and all its sessions are deleted.
    """
    from graphengine.recording.sources import Workspace

    folder = tempfile.TemporaryDirectory(prefix="graphengine-")
    path, options = packed.lay_out(Workspace(Path(folder.name)))
    scene = open_scene(path, replace(options, registry=make_registry(modules) if modules else None), modules)
    weakref.finalize(loaded_of(scene), folder.cleanup)
    return scene
