"""Plan to Python source: one function a region, copies as attribute stores, flags as integers, nothing nested.

The generated text is registered with `linecache`, so a traceback shows its lines, and each line knows its node, so that an
exception names it without a try around every call. Keeping a run going after a fault, or timing each node, is other generated
text; the plain tick has no hooks.
"""

from __future__ import annotations

import itertools
import linecache
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

from graphengine import types
from graphengine.node import Node
from graphengine.plan import Call, Copy, Fire, Plan, Refresh, Region

_serial = itertools.count()


@dataclass(slots=True)
class Source:
    """Generated text, and for each of its lines the node that it runs."""

    name: str
    lines: list[str] = field(default_factory=list)
    nodes: list[int | None] = field(default_factory=list)

    def add(self, lines: Iterable[str], node: int | None = None, indent: int = 0) -> None:
        """Append lines that run a node."""
        for line in lines:
            self.lines.append("    " * indent + line)
            self.nodes.append(node)

    @property
    def text(self) -> str:
        """All of it."""
        return "\n".join(self.lines) + "\n"

    def node_at(self, line: int) -> int | None:
        """The node that a line, counted from 1, runs."""
        return self.nodes[line - 1] if 1 <= line <= len(self.nodes) else None


def write_source(plan: Plan, *, keep_going: bool = False) -> Source:
    """The text of a plan's functions: `constants`, and one a region, of which `pass_` is the root.

    Args:
        plan: what to do.
        keep_going: a node that raises ends its branch only, and is reported through `fault`.
    """
    graph = plan.graph
    source = Source(f"<graph: {graph.flat.loaded.document.source.path} as {graph.name} #{next(_serial)}>")
    source.add([f"s{data} = 1" for data in plan.flagged])
    source.add([f"l{index} = 0" for index, _ in plan.root.pending])
    _write_constants(plan, source)
    for region in reversed(plan.regions):  # children first reads like definitions before use
        _write_region(plan, region, source, keep_going)
    return source


def _name(plan: Plan, index: int) -> str:
    return plan.graph.instances[index].id


def _write_constants(plan: Plan, source: Source) -> None:
    source.add(["", "def constants():"])
    body = 0
    for refresh in plan.constants:
        source.add([*_copies(refresh.copies), f"c{refresh.node}()"], refresh.node, 1)
        body += 1
    for copy in plan.constant_copies:
        source.add(_copy(copy), copy.target, 1)
        body += 1
    if not body:
        source.add(["pass"], None, 1)


def _write_region(plan: Plan, region: Region, source: Source, keep_going: bool) -> None:
    name = "pass_" if region.index == 0 else f"r{region.index}"
    used = sorted({index for call in region.calls for index in _nodes_of(call)})
    bound = "".join(f", n{i}=n{i}, c{i}=c{i}" for i in used)
    stale = sorted({s for call in region.calls for s in _stale_of(call)} | set(region.stale))
    latent = [index for index, _ in region.pending]
    source.add(["", f"def {name}({bound.removeprefix(', ')}):  # {region.title}"])
    if stale or latent:
        source.add([f"global {', '.join([*(f's{s}' for s in stale), *(f'l{i}' for i in latent)])}"], None, 1)
    if region.flags:
        source.add([f"{' = '.join(region.flags)} = 0"], None, 1)
    source.add([f"s{data} = 1" for data in region.stale], None, 1)
    for index, branches in region.pending:
        lines = [line for branch in branches for line in _branch(branch.mask, branch.fires, many=True)]
        source.add(
            [f"if l{index}:", f"    p = l{index}", f"    l{index} = 0", *(f"    {line}" for line in lines)], index, 1
        )
    source.add([line for fire in region.entries for line in _fire(fire)], None, 1)
    for guard, calls in itertools.groupby(region.calls, key=lambda call: call.guard):
        if guard:
            source.add([f"if {guard}:"], None, 1)
        for call in calls:
            source.add([f"# {_name(plan, call.node)}"], None, 2 if guard else 1)
            source.add(_call(call, keep_going), call.node, 2 if guard else 1)
    if not region.calls:
        source.add(["pass"], None, 1)


def _nodes_of(call: Call) -> Iterator[int]:
    """Nodes whose names a call's text uses."""
    yield call.node
    for refresh in call.refreshes:
        yield refresh.node
        yield from (copy.source for copy in refresh.copies)
    yield from (copy.source for copy in call.copies)
    yield from (fire.target for branch in call.branches for fire in branch.fires if fire.pin)


def _stale_of(call: Call) -> Iterator[int]:
    yield from call.marks
    yield from (refresh.node for refresh in call.refreshes if refresh.flagged)


# One function a step kind


def _copy(copy: Copy) -> list[str]:
    value = f"n{copy.source}.{copy.source_field}"
    if copy.converter:
        value = f"{copy.converter}({value})"
    place = f"n{copy.target}.{copy.target_field}"
    if not copy.setup:
        return [f"{place} = {value}"]
    return [f"v = {value}", f"if not equal(v, {place}):", f"    {place} = v", f"    setup_again({copy.target})"]


def _copies(copies: Iterable[Copy]) -> list[str]:
    return [line for copy in copies for line in _copy(copy)]


def _refresh(refresh: Refresh) -> list[str]:
    clear = [f"s{refresh.node} = 0"] if refresh.flagged else []
    lines = [*clear, *_copies(refresh.copies), f"c{refresh.node}()"]
    return [f"if s{refresh.node}:", *(f"    {line}" for line in lines)] if refresh.if_stale else lines


def _fire(fire: Fire) -> list[str]:
    lines = [f"{fire.guard} = 1"] if fire.guard else []
    if fire.activation:
        lines.append(f"{fire.activation} += 1")
    if fire.pin:
        lines.append(f"n{fire.target}.{fire.pin} += 1")
    return lines


def _branch(mask: int, fires: Iterable[Fire], *, many: bool) -> list[str]:
    """What follows an execution output of a gated node, whose result is in `p`."""
    lines = [line for fire in fires for line in _fire(fire)]
    return [f"if p & {mask}:" if many else "if p:", *(f"    {line}" for line in lines)] if lines else []


def _call(call: Call, keep_going: bool) -> list[str]:
    lines = [line for refresh in call.refreshes for line in _refresh(refresh)]
    lines += _copies(call.copies)
    if not call.activations:
        return [*lines, *_guarded(call, _compute(call), keep_going)]
    for activation in call.activations:
        body = [f"n{call.node}.{activation.pin} += 1", *_guarded(call, _compute(call), keep_going)]
        lines += [f"for _ in range({activation.flag}):", *(f"    {line}" for line in body)]
    return lines


def _compute(call: Call) -> list[str]:
    """The call itself and what its result leads to."""
    node, marks = call.node, [f"s{data} = 1" for data in call.marks]
    clear = [f"n{node}.{pin} = 0" for pin in call.pins]
    if call.kind == "pusher":
        return [*_push(call, marks), *clear]
    if call.kind == "latent":
        return [f"c{node}()", *marks, *clear, f"if n{node}.active:", f"    activate({node})"]
    if not call.gated:
        fires = [line for branch in call.branches for fire in branch.fires for line in _fire(fire)]
        return [f"c{node}()", *marks, *clear, *fires]
    many = len(call.branches) > 1 or any(branch.mask != 1 for branch in call.branches)
    follow = [line for branch in call.branches for line in _branch(branch.mask, branch.fires, many=many)]
    if not follow:
        return [f"c{node}()", *marks, *clear]
    if many:
        return [f"p = c{node}()", *marks, *clear, "if p:", *(f"    {line}" for line in follow)]
    return [f"p = c{node}()", *marks, *clear, *follow]


def _push(call: Call, marks: list[str]) -> list[str]:
    """A pusher: each yield runs the region of the port to its end; `|` of several ports runs them in order."""
    opened = [branch for branch in call.branches if branch.region >= 0]
    body = [*marks]
    for branch in opened:
        body += [f"if p & {branch.mask}:", f"    r{branch.region}()"]
    return [f"for p in c{call.node}():", *(f"    {line}" for line in body or ["pass"]), *marks]


def _guarded(call: Call, lines: list[str], keep_going: bool) -> list[str]:
    if not keep_going:
        return lines
    clear = [f"    n{call.node}.{pin} = 0" for pin in call.pins]
    return [
        "try:",
        *(f"    {line}" for line in lines),
        "except Exception as error:",
        f"    fault({call.node}, error)",
        *clear,
    ]


def compile_source(
    source: Source,
    nodes: list[Node],
    setup_again: Callable[[int], None],
    activate: Callable[[int], None],
    fault: Callable[[int, Exception], None],
) -> dict[str, Any]:
    """The functions of a generated text, bound to their nodes."""
    namespace: dict[str, Any] = {"setup_again": setup_again, "activate": activate, "fault": fault, "equal": types.equal}
    namespace |= types.CONVERTERS
    namespace |= {f"n{i}": node for i, node in enumerate(nodes)}
    namespace |= {f"c{i}": node.compute for i, node in enumerate(nodes)}
    linecache.cache[source.name] = (len(source.text), None, source.text.splitlines(keepends=True), source.name)
    exec(
        compile(source.text, source.name, "exec"), namespace
    )  # our own text: names in it are indices and fields of classes
    return namespace
