"""Limits of the rooms format, messages, sandbox, compiler and node."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from graphengine.compiler.budget import Budget, OverBudgetError
from graphengine.devices.dry_world import DryWorld
from graphengine.devices.stage import Stage
from graphengine.format import document, files, ros_packages
from graphengine.format.diagnostics import Finding, Findings, Source, Span
from graphengine.format.errors import ContextError, TopicError
from graphengine.format.files import Files
from graphengine.format.permissions import Permissions
from graphengine.format.spec import EverySpec, RobotUse
from graphengine.format.wording import printable
from graphengine.messages import action_client, goals, names, qos
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.goals import Goals, TrackedGoal
from graphengine.messages.interfaces import MessageTypeError
from graphengine.node.mailbox import EventQueue
from graphengine.node.prims import attributes
from graphengine.sandbox import untrusted
from graphengine.sandbox.confinement import ProcessError, ask
from graphengine.sandbox.expressions import ForbiddenError, Guard, compiled
from graphengine.scene import build
from tests.limits.table import accepts, limit, repeat

# format


@limit("format.diagnostics.MAX_ERRORS", at=3)
def _(errors: int) -> bool:
    findings = Findings()
    for number in range(errors):
        findings.add("G101", f"error {number}")
    return not findings.full and len(findings.items) == errors


@limit("format.diagnostics.MAX_GUESSES", at=3)
def _(searches: int) -> bool:
    findings = Findings()
    return "" not in [findings.guess("dd10", ["dd100"]) for _ in range(searches)]


def is_read(path: Path, text: str) -> bool:
    path.write_text(text, encoding="utf-8")
    return document.load(path, Findings()) is not None


@limit("format.document.MAX_BYTES", at=100)
def _(size: int, folder: Path) -> bool:
    return is_read(folder / "a.yaml", f"a: {'x' * (size - 3)}")


@limit("format.document.MAX_BYTES", at=1000)
def _(size: int, folder: Path) -> bool:
    """Text that replaces parameters counts at each use."""
    path, half = folder / "a.yaml", "x" * (size // 2)
    parameters = f"half: {{type: token, default: {half}}}, one: {{type: token, default: x}}"
    uses = "$(half)$(half)" + "$(one)" * (size % 2)
    node = f"{{type: ConstantToken, inputs: {{value: '{uses}'}}}}"
    path.write_text(f"graph: a\nparameters: {{{parameters}}}\nnodes: {{A: {node}}}\n", encoding="utf-8")
    found = [finding.code for finding in build.load(path).findings.errors]
    assert found in ([], ["G105"])
    return not found


@limit("format.document.MAX_DEPTH")
def _(levels: int, folder: Path) -> bool:
    return is_read(folder / "a.yaml", "[" * levels + "]" * levels)


@limit("format.document.MAX_VALUES", at=10)
def _(values: int, folder: Path) -> bool:
    return is_read(folder / "a.yaml", f"[{'x, ' * (values - 1)}]")


@limit("format.document.MAX_VALUES", at=10)
def _(values: int) -> bool:
    return accepts(lambda: Budget(Span(Source("a.yaml", ()), 1, 1), Findings()).take_values(values), OverBudgetError)


@limit("format.files.MAX_NAMED", at=2)
def _(scenes: int, folder: Path) -> bool:
    for number in range(scenes):
        (folder / f"{number}.yaml").write_text("scene: a\n", encoding="utf-8")
    return len(files._scenes_in(folder)) == scenes


@limit("format.files.MAX_SEARCHED", at=50)
def _(bytes_before_the_end_of_the_key: int, folder: Path) -> bool:
    key = "\nscene:"
    (folder / "a.yaml").write_text("#" * (bytes_before_the_end_of_the_key - len(key)) + f"{key} a\n", encoding="utf-8")
    return len(files._scenes_in(folder)) == 1


@limit("format.permissions.LARGEST_FILE", at=10)
def _(size: int, folder: Path) -> bool:
    (folder / "a.txt").write_text("x" * size, encoding="utf-8")
    return accepts(lambda: Permissions(Files((folder,))).read("a.txt", folder), ContextError)


@limit("format.ros_packages.MAX_FOLDERS", at=3)
def _(folders: int, folder: Path) -> bool:
    for number in range(folders - 1):
        (folder / str(number)).mkdir()
    return len(list(ros_packages.walk(folder, 5, lambda names: False))) == folders


@limit("format.ros_packages._MAX_BYTES", at=100)
def _(size: int, folder: Path) -> bool:
    name = "<name>a</name>"
    (folder / "package.xml").write_text("<package>" + " " * (size - 9 - len(name)) + name, encoding="utf-8")
    return ros_packages.manifest_name(folder) == "a"


@limit("format.spec.MAX_TICKS")
def _(ticks: int) -> bool:
    return accepts(lambda: EverySpec(ticks=ticks), ValidationError)


@limit("format.spec.MAX_HZ")
def _(hz: int) -> bool:
    return accepts(lambda: EverySpec(hz=hz), ValidationError)


@limit("format.spec.MAX_ROBOTS")
def _(robots: int) -> bool:
    return accepts(lambda: RobotUse(use="robot.yaml", count=robots, spacing=(1.0, 1.0)), ValidationError)


@limit("format.spec.MAX_ROBOTS")
def _(robots: int) -> bool:
    return accepts(lambda: RobotUse(use="robot.yaml", places=[{}] * robots), ValidationError)  # type: ignore[arg-type]


@limit("format.wording._LONGEST")
def _(letters: int) -> bool:
    return printable("x" * letters) == "x" * letters


# messages


@limit("messages.action_client.MAX_OPEN", at=3)
def _(goals_without_result: int) -> bool:
    known = dict.fromkeys(range(goals_without_result))
    action_client._limit(known)
    return len(known) == goals_without_result


def package(folder: Path, **definitions: str) -> Any:
    (folder / "my_msgs" / "msg").mkdir(parents=True)
    for name, text in definitions.items():
        (folder / "my_msgs" / "msg" / f"{name}.msg").write_text(text, encoding="utf-8")
    return DEFINITIONS.extended([folder])


def is_defined(definitions: Any, name: str = "my_msgs/msg/Thing") -> bool:
    return accepts(lambda: definitions.initial(name), MessageTypeError)


@limit("messages.definitions.MAX_NESTING", at=4)
def _(levels: int, folder: Path) -> bool:
    parts = {f"Level{number}": f"Level{number + 1} next" for number in range(1, levels - 1)}
    return is_defined(package(folder, Thing="Level1 next", **parts, **{f"Level{levels - 1}": "int32 a"}))


@limit("messages.definitions.MAX_VALUES", at=10)
def _(values: int, folder: Path) -> bool:
    return is_defined(package(folder, Thing=f"float64[{values}] a"))


@limit("messages.folders.MAX_DEPTH")
def _(levels: int, folder: Path) -> bool:
    deep = folder.joinpath(*map(str, range(levels - 2)))
    package(deep, Thing="int32 a")
    return is_defined(DEFINITIONS.extended([folder]))


@limit("messages.interfaces.MAX_BYTES", at=100)
def _(size: int, folder: Path) -> bool:
    return is_defined(package(folder, Thing="int32 a\n".ljust(size, "#")))


def ended_goals(number: int) -> Goals[TrackedGoal]:
    table = Goals[TrackedGoal]("example_interfaces/action/Fibonacci", DEFINITIONS)
    for identity in range(number):
        goal = TrackedGoal(bytes([identity]))
        assert table.admit(goal)
        goal.status = goals.SUCCEEDED
    return table


@limit("messages.goals.MAX_ACTIVE", at=3)
def _(active: int) -> bool:
    table = Goals[TrackedGoal]("example_interfaces/action/Fibonacci", DEFINITIONS)
    return False not in [table.admit(TrackedGoal(bytes([identity]))) for identity in range(active)]


@limit("messages.goals.MAX_ENDED", at=3)
def _(ended: int) -> bool:
    return not ended_goals(ended).expire(0.0)


@limit("messages.goals.RESULT_TIMEOUT")
def _(seconds: float) -> bool:
    table = ended_goals(1)
    table.expire(0.0)
    return not table.expire(seconds)


@limit("messages.goals.MAX_WAITING", at=3)
def _(requests: int) -> bool:
    goal = TrackedGoal(b"a")
    goal.waiting.extend(range(requests))
    return len(goal.waiting) == requests


@limit("messages.names.MAX_TOPIC")
def _(letters: int) -> bool:
    return accepts(lambda: names.check_topic(f"/{'a' * (letters - 1)}"), TopicError)


@limit("messages.names.MAX_NAMESPACE")
def _(letters: int) -> bool:
    return accepts(lambda: names.check_namespace(f"/{'a' * (letters - 1)}"), TopicError)


@limit("messages.names.MAX_NODE")
def _(letters: int) -> bool:
    return accepts(lambda: names.check_node_name("a" * letters), TopicError)


@limit("messages.qos._MAX_DEPTH")
def _(depth: int) -> bool:
    return accepts(lambda: qos._depth(depth, "depth", depth), TopicError)


# node


@limit("node.mailbox.EventQueue.LIMIT")
def _(events: int) -> bool:
    queue = EventQueue("event:bell")
    return accepts(lambda: repeat(events, queue.post), ContextError)


@limit("node.prims.attributes.BRIGHTEST")
def _(intensity: float) -> bool:
    return accepts(lambda: attributes._bright([intensity]), ContextError)


@limit("node.prims.attributes.STRONGEST_GRAVITY")
def _(strength: float) -> bool:
    world = DryWorld(Stage())
    write = attributes.of_gravity(world)["physics:gravityMagnitude"].write
    assert write is not None
    return accepts(lambda: write(strength), ContextError)


# compiler


@limit("compiler.subgraph_expansion.MAX_SUBGRAPH_DEPTH")
def _(levels: int, folder: Path) -> bool:
    for number in range(levels):
        text = f"graph: g\nnodes: {{N: {{subgraph: {number + 1}.yaml}}}}\n"
        (folder / f"{number}.yaml").write_text(text, encoding="utf-8")
    (folder / f"{levels}.yaml").write_text("graph: g\nnodes: {N: OnPlaybackTick}\n", encoding="utf-8")
    return "G214" not in [finding.code for finding in build.load(folder / "0.yaml").findings.items]


# sandbox


def is_evaluated(text: str) -> bool:
    return accepts(lambda: Guard().evaluate(compiled(text), {}), ForbiddenError)


@limit("sandbox.expressions.MAX_CHARACTERS", at=100)
def _(characters: int) -> bool:
    return is_evaluated("1".ljust(characters))


@limit("sandbox.expressions.MAX_DEPTH", at=20)
def _(levels: int) -> bool:
    return is_evaluated("-" * (levels - 2) + "1")  # the expression and the number are two levels


@limit("sandbox.expressions.MAX_BITS", at=100)
def _(bits: int) -> bool:
    return is_evaluated(f"1 << {bits - 1}")


@limit("sandbox.expressions.MAX_STEPS", at=100)
def _(steps: int) -> bool:
    return accepts(lambda: Guard().spend(steps), ForbiddenError)


def reads(kind: Any, data: Any, most: int = 1000) -> bool:
    return accepts(lambda: untrusted.read(json.dumps(data, separators=(",", ":")).encode(), kind, most), ProcessError)


@limit("sandbox.untrusted.MAX_FINDINGS", at=3)
def _(number: int) -> bool:
    findings = Findings()
    untrusted.take_findings([Finding("W302", f"{item}") for item in range(number)], findings)
    return [finding.message for finding in findings.items] == [f"{item}" for item in range(number)]


@limit("sandbox.untrusted.MAX_LINES", at=3)
def _(lines: int) -> bool:
    findings, helps = Findings(), tuple(map(str, range(lines)))
    untrusted.take_findings([Finding("W302", "a", None, helps)], findings)
    return findings.items[0].help == helps


@limit("sandbox.untrusted.MAX_FILES", at=3)
def _(number: int, folder: Path) -> bool:
    read, paths = Files((folder,)), [folder / str(item) for item in range(number)]
    for path in paths:
        path.touch()
    untrusted.note_used(map(str, paths), read)
    return len(read.used) == number


@limit("sandbox.untrusted.MAX_NUMBER")
def _(line: int, folder: Path) -> bool:
    (folder / "a").touch()
    return untrusted.Sources(Files((folder,))).span(str(folder / "a"), line, 1, 1).line == line


@limit("sandbox.untrusted.MAX_DEPTH")
def _(levels: int) -> bool:
    value: Any = 1
    for _ in range(levels):
        value = [value]
    return accepts(lambda: untrusted.typed(Any, value, lambda: None), TypeError)  # type: ignore[arg-type,return-value]


def process(folder: Path, code: str) -> bytes | str:
    """Return the answer of a process that runs code, or why it has none."""
    (folder / "limited.py").write_text(code, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)
        try:
            return ask("limited", b"", 60)
        except ProcessError as error:
            return str(error)


@limit("sandbox.confinement.MAX_ANSWER_BYTES", at=100_000)
def _(size: int, folder: Path) -> bool:
    return len(process(folder, f"print('x' * {size - 1})")) == size


@limit("sandbox.confinement.MAX_REASON", at=50)
def _(letters: int, folder: Path) -> bool:
    return process(folder, f"raise SystemExit('x' * {letters})") == "x" * letters


@limit("sandbox.confinement.MAX_COMPLAINT_BYTES", at=50)
def _(size: int, folder: Path) -> bool:
    return process(folder, f"raise SystemExit('x' * {size})") == "x" * size
