"""`graphrun replay`: replay a recorded run and compare the output byte by byte."""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from graphengine.cli.quantities import whole

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from graphengine.api.run_options import RunOptions
    from graphengine.compiler.registry import Registry
    from graphengine.physics.sensors.rays import RaysChoice
    from graphengine.recording.manifest import Manifest
    from graphengine.recording.reader import Recording
    from graphengine.recording.replay import Difference, Replay
    from graphengine.runtime.session_core import SessionCore
    from graphengine.scene.loaded_scene import Options

LONGEST = 80
"""Characters of a port's value that are told."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    from graphengine.cli.common import add_allow_argument, add_import_argument, add_permission_arguments, add_repeatable

    parser.add_argument("recording", metavar="FILE", type=Path, help="a recording of `graphrun run --record FILE`")
    against = "run this scene or graph instead of the files in the recording"
    parser.add_argument("--against", metavar="SCENE|GRAPH", help=against)
    add_repeatable(parser, "--ignore", "TOPIC", "topic to leave out of the comparison; globs allowed")
    values = "set an input to a value, in addition to the run's own settings; [ROBOT/][GRAPH/]NODE.PORT, globs allowed"
    add_repeatable(parser, "--set", "NODE.PORT=VALUE", values)
    parser.add_argument("--seed", type=whole, help="seed instead of the run's")
    parser.add_argument("--rays", choices=("auto", "mujoco", "fast"), help="ray casting instead of the run's")
    add_allow_argument(parser)
    add_import_argument(parser)
    add_permission_arguments(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Replay and compare; return 0 if all bytes are equal, 1 if not, 2 if they cannot be compared."""
    from graphengine.cli.common import clean, explain
    from graphengine.format.errors import CheckError, GraphError, RecordingError, UsageError
    from graphengine.recording.reader import Recording
    from graphengine.recording.sources import Workspace

    with tempfile.TemporaryDirectory(prefix="graphrun-") as folder:
        place = f"{Path(folder).resolve()}{os.sep}"

        def plain(text: str) -> str:
            """The text with files named as in the recording."""
            return clean(text.replace(place, ""))

        try:
            return _replay(arguments, Recording(arguments.recording, Workspace(Path(folder))), plain)
        except (RecordingError, UsageError) as error:
            raise UsageError(plain(str(error))) from None
        except GraphError as error:
            told = str(error) if isinstance(error, CheckError) else f"error: {explain(error)}"
            print(plain(told), file=sys.stderr)
            return 1


def _replay(arguments: argparse.Namespace, recording: Recording, plain: Callable[[str], str]) -> int:
    from graphengine.api.scene import start_runner
    from graphengine.api.scene_loading import open_scene
    from graphengine.cli.progress import progress
    from graphengine.format.errors import CheckError, RecordingError, UsageError
    from graphengine.recording import platform_info
    from graphengine.recording.replay import Replay

    def warn(text: str) -> None:
        print(plain(f"warning: {text}"), file=sys.stderr)

    try:
        scene = open_scene(*_what_to_run(arguments, recording))
    except CheckError as error:
        for finding in error.findings:
            if finding.severity == "error":
                print(plain(finding.render()), file=sys.stderr)
        return 1
    if arguments.against and any(finding.code == "N102" for finding in scene.findings):
        raise UsageError(f"{arguments.against} asks for prims of a scene; give a scene to --against")
    with start_runner(scene, _how_to_run(recording.manifest, warn)) as runner:
        session = runner.session
        here = platform_info.describe(runner.scene, session.services.world)
        for line in platform_info.differences(recording.manifest.machine, here):
            warn(f"{line}; results may differ in their last bits")
        run = Replay(session, runner.network, recording, arguments.ignore, warn)
        try:
            with progress("replaying", lambda: recording.share_read, 1.0):
                found = run.run()
        except RecordingError as error:
            raise RecordingError(f"{error}\n  up to there {_counted(run)} are identical") from None
        for pattern in sorted(run.idle_patterns) if found is None else ():
            warn(f"--ignore {pattern}: nothing was sent on such a topic")
        if found is None and recording.cut_off:
            warn(f"the run was cut off: the recording ends at t = {recording.times.seconds(run.ticks):.3f} s")
        print(plain(_verdict(found, run, session, recording)))
    return 1 if found else 0


def _what_to_run(arguments: argparse.Namespace, recording: Recording) -> tuple[Path, Options]:
    """The file and the options of the recording, changed by the command line."""
    from graphengine.cli.common import environment, parse_set, reading_options
    from graphengine.format.files import find_file

    manifest, files = recording.manifest, recording.workspace
    options = replace(
        reading_options(arguments),
        overrides={**manifest.overrides, **dict(parse_set(text) for text in arguments.set)},
        seed=manifest.seed if arguments.seed is None else arguments.seed,
        robot_state=manifest.robot_state,
        rays=_rays(arguments.rays or manifest.rays, recording.path),
        registry=_registry(manifest.modules, arguments.modules, recording.path),
        environment=environment(arguments),
        scripts=arguments.allow_scripts,
    )
    if arguments.against:
        return find_file(arguments.against), options
    return files.path(manifest.given), files.options(options, manifest.scene)


def _how_to_run(manifest: Manifest, warn: Callable[[str], None]) -> RunOptions:
    """The options of the recorded session, on a network on which only the recording is heard."""
    from graphengine.api.run_options import RunOptions
    from graphengine.recording.replay import SilentTransport

    domain = manifest.domain_from_environment
    return RunOptions(
        keep_going=manifest.keep_going,
        bad_values=manifest.bad_values,
        domain=manifest.domain_id,
        environ={} if domain is None else {"ROS_DOMAIN_ID": str(domain)},
        join=lambda joined: SilentTransport(definitions=joined.definitions),
        log=lambda *_: None,
        complain=warn,
    )


def _rays(rays: RaysChoice, recording: Path) -> RaysChoice:
    """The ray casting to use for lidars.

    Raises:
        UsageError: it is not available.
    """
    from graphengine.format.errors import UsageError

    if rays == "fast" and find_spec("numba") is None:
        raise UsageError(
            f"{recording}: its lidars used rays 'fast', which need numba\n  pip install 'graphengine[fast]'\n"
            "  or give --rays mujoco: distances are the same to a nanometre, not to the last bit"
        )
    return rays


def _registry(recorded: Sequence[str], given: Sequence[str], recording: Path) -> Registry | None:
    """The registry of node types; only modules given on the command line are imported.

    Raises:
        UsageError: a module of the recorded run is not given.
    """
    from graphengine.cli.common import make_registry
    from graphengine.compiler.registry import default_registry
    from graphengine.format.errors import UsageError

    library = set(default_registry().modules.values())
    ours = [name for name in recorded if any(f"{known}.".startswith(f"graphengine.{name}.") for known in library)]
    missing = [module for module in recorded if module not in (*given, *ours)]  # the library was once called `nodes`
    if missing:
        remedy = " ".join(f"--import {module}" for module in missing)
        raise UsageError(f"{recording}: the run used additional node types; if you trust them, give {remedy}")
    return make_registry(given) if given else None


def _verdict(found: Difference | None, run: Replay, session: SessionCore, recording: Recording) -> str:
    """The result of the comparison as text."""
    if found is None:
        return f"identical: {_counted(run)}, {recording.times.seconds(run.ticks):.3f} s"
    when = f"{'at the end, after' if found.at_end else 'in'} tick {found.tick}, t = {found.time:.6f} s"
    where = f"different {when}{f': {found.topic}' if found.topic else ''}"
    lines = [line for text in found.lines for line in text.split("\n")]
    return "\n  ".join(
        [where, *_published_by(found.node, session), *lines, f"before that, {_counted(run)} are identical"]
    )


def _counted(run: Replay) -> str:
    from graphengine.cli.common import counted

    return f"{counted(run.messages, 'message')} in {counted(run.ticks, 'tick')}"


def _published_by(node: str, session: SessionCore) -> list[str]:
    """Lines on the publishing node: type, place in its file, and port values in the replay."""
    for run in session.graphs:
        graph = run.executor.graph
        for instance in graph.instances:
            if f"{graph.prim_path}/{instance.id}" == node:
                wires = [wire for wire in graph.data_wires if wire.target == instance.index]
                read = [
                    f"{wire} = {_short(getattr(run.executor.nodes[wire.target], wire.target_field))}" for wire in wires
                ]
                return [f"published by {node} ({instance.cls.type_name}, {instance.span})", *read]
    return [f"published by {node}"] if node else []


def _short(value: object) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}…"
