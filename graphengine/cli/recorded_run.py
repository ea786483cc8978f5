"""Starts the session of a recording, for `graphrun replay` and `graphrun view`."""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from graphengine.cli.common import clean, explain
from graphengine.format.diagnostics import CheckError
from graphengine.format.distribution import install_command
from graphengine.format.errors import GraphError, RecordingError, UsageError

if TYPE_CHECKING:
    from graphengine.api.run_options import Log, RunOptions
    from graphengine.api.runner import Runner
    from graphengine.compiler.registry import Registry
    from graphengine.physics.ray_casting.rays import RaysChoice
    from graphengine.recording.manifest import Manifest
    from graphengine.recording.reader import Recording
    from graphengine.scene.loaded_scene import Options


@dataclass(frozen=True, slots=True)
class RecordedRun:
    """A recording and the session that will replay it, before the first tick.

    Attributes:
        recording: the recording; no tick has been read yet.
        runner: runner of the session; its network delivers only the recorded messages.
        plain: replaces the paths of extracted files in a text by the file names in the recording.
        warn: prints a warning to standard error.
    """

    recording: Recording
    runner: Runner
    plain: Callable[[str], str]
    warn: Callable[[str], None]


Use = Callable[[RecordedRun], int]
"""Function that uses a recorded run and returns the exit code."""


def start_recorded_run(arguments: argparse.Namespace, use: Use, log: Log = lambda *_: None) -> int:
    """Start the session of the recording that the command line names, and call `use` with it.

    Args:
        arguments: arguments of `graphrun replay` or `graphrun view`.
        use: replays the session.
        log: receives the messages of nodes: severity, prim path of the node, and text.

    Returns:
        The result of `use`. If the scene or a node has an error, the error is printed and 1 is returned.

    Raises:
        UsageError: the file cannot be replayed.
    """
    from graphengine.format.files import require_file
    from graphengine.recording.reader import Recording
    from graphengine.recording.sources import Workspace

    require_file(arguments.recording)
    with tempfile.TemporaryDirectory(prefix="graphrun-") as folder:
        place = f"{Path(folder).resolve()}{os.sep}"

        def plain(text: str) -> str:
            return clean(text.replace(place, ""))

        try:
            return _start(arguments, Recording(arguments.recording, Workspace(Path(folder))), plain, use, log)
        except (RecordingError, UsageError) as error:
            raise UsageError(plain(str(error))) from None
        except GraphError as error:
            told = str(error) if isinstance(error, CheckError) else f"error: {explain(error)}"
            print(plain(told), file=sys.stderr)
            return 1


def _start(arguments: argparse.Namespace, recording: Recording, plain: Callable[[str], str], use: Use, log: Log) -> int:
    from graphengine.api.scene import start_runner
    from graphengine.api.scene_loading import open_scene
    from graphengine.recording import platform_info

    try:
        scene = open_scene(*_what_to_run(arguments, recording))
    except CheckError as error:
        for finding in error.findings:
            if finding.severity == "error":
                print(plain(finding.render()), file=sys.stderr)
        return 1
    for finding in scene.findings:
        if finding.code == "W109":
            print(plain(finding.render()), file=sys.stderr)
    if arguments.against and any(finding.code == "N102" for finding in scene.findings):
        raise UsageError(f"--against {arguments.against}: the graph uses prims of a scene; give a scene instead")

    def warn(text: str) -> None:
        print(plain(f"warning: {text}"), file=sys.stderr)

    with start_runner(scene, _how_to_run(recording.manifest, warn, log)) as runner:
        here = platform_info.describe(runner.scene, runner.session)
        for line in platform_info.differences(recording.manifest.machine, here):
            warn(f"{line}; results may differ in their last bits")
        return use(RecordedRun(recording, runner, plain, warn))


def _what_to_run(arguments: argparse.Namespace, recording: Recording) -> tuple[Path, Options]:
    """Return the file to load, and the loading options of the recorded run, changed by the command line.

    Raises:
        UsageError: an option is invalid, a module with node types is not given, or numba is not installed.
    """
    from graphengine.cli.common import environment, parse_set, reading_options
    from graphengine.format.files import find_file

    manifest, files = recording.manifest, recording.workspace
    options = replace(
        reading_options(arguments),
        overrides={**manifest.overrides, **dict(parse_set(text) for text in arguments.set)},
        seed=manifest.seed if arguments.seed is None else arguments.seed,
        robot_state=manifest.robot_state,
        localization=manifest.localization,
        distro=arguments.distro or manifest.distro,
        rays=_rays(arguments.rays or manifest.rays, recording.path),
        registry=_registry(manifest.modules, arguments.modules, recording.path),
        environment=environment(arguments),
        scripts=arguments.allow_scripts,
    )
    if arguments.against:
        return find_file(arguments.against), options
    options = replace(options, sees_own_robots=manifest.sees_own_robots)
    return files.path(manifest.given), files.options(options, manifest.scene)


def _how_to_run(manifest: Manifest, warn: Callable[[str], None], log: Log) -> RunOptions:
    """Return the session options of the recorded run, with a network that delivers only the recorded messages."""
    from graphengine.api.run_options import RunOptions
    from graphengine.recording.replay import SilentTransport

    domain = manifest.domain_from_environment
    return RunOptions(
        keep_going=manifest.keep_going,
        bad_values=manifest.bad_values,
        domain=manifest.domain_id,
        environ={} if domain is None else {"ROS_DOMAIN_ID": str(domain)},
        join=lambda joined: SilentTransport(bytes.fromhex(manifest.identity), joined.definitions),
        log=log,
        complain=warn,
    )


def _rays(rays: RaysChoice, recording: Path) -> RaysChoice:
    """Return the given method of ray casting if it is available.

    Raises:
        UsageError: the method needs numba, which is not installed.
    """
    if rays == "fast" and find_spec("numba") is None:
        raise UsageError(
            f"{recording}: the run cast the rays of lidars with --rays fast, which needs numba\n"
            f"  {install_command('fast')}\n"
            "  or give --rays mujoco: the distances then agree to a nanometre, but not in every bit"
        )
    return rays


def _registry(recorded: Sequence[str], given: Sequence[str], recording: Path) -> Registry | None:
    """Import the modules given on the command line and return a registry with their node types; None without modules.

    A module is imported only if the command line names it, because the recording could come from someone else.

    Raises:
        UsageError: the recorded run used a module that the command line does not give.
    """
    from graphengine.cli.common import make_registry
    from graphengine.compiler.registry import default_registry

    library = set(default_registry().modules.values())
    ours = [name for name in recorded if any(f"{known}.".startswith(f"graphengine.{name}.") for known in library)]
    missing = [module for module in recorded if module not in (*given, *ours)]  # the library was once called `nodes`
    if missing:
        options = " ".join(f"--import {module}" for module in missing)
        remedy = f"if you trust these modules, give {options}"
        raise UsageError(f"{recording}: the run used modules with node types; {remedy}")
    return make_registry(given) if given else None
