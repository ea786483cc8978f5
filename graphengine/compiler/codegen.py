"""Generates Python source from a plan: one function per region, copies as attribute assignments, flags as integers.

The source is registered with `linecache`, so a traceback shows its lines. The node of each line is recorded, so that error
messages can name the node. Each call of a node is in a `try`, which costs nothing until the node raises an exception. `caught`
holds the types of exceptions (BadValueError, Exception, or none) after which the pass continues, without the nodes that the
failed node would have fired; any other exception ends the pass.
"""

from __future__ import annotations

import itertools
import re
import weakref
from collections import Counter
from collections.abc import Callable, Collection, Container, Iterable, Iterator, Mapping, Sequence
from typing import Any

from graphengine.compiler.generated_source import VARIABLE, GeneratedSource
from graphengine.compiler.plan import Call, Copy, ExecBranch, FireEffect, Plan, Refresh, Region
from graphengine.compiler.staleness import mark_stale, stale_upstream
from graphengine.node import types
from graphengine.node.node_class import Node

MAX_MARKS = 8
"""Maximum number of flags that the code after a call sets one by one; to set more, it calls a function."""
MAX_CALLS = 250
"""Maximum number of calls in a generated function.

A function with thousands of variables is slow: CPython allocates and frees the memory of its frame at each call.
"""
_serial = itertools.count()
_FUNCTIONS = re.compile(r"(?<![.\w])((?:pass_|constants|at_stop|at_close|refresh|[dr]\d+)(?:_part\d+)?)\b(?=[(,}])")
"""Pattern of the name of a generated function where it is defined, called, or named in a table."""
_programs: weakref.WeakKeyDictionary[Plan, GeneratedSource] = weakref.WeakKeyDictionary()


def source_of(plan: Plan) -> GeneratedSource:
    """Return the generated source of a plan; it is generated at the first call, and all sessions share it."""
    if plan not in _programs:
        _programs[plan] = _write_source(plan)
    return _programs[plan]


def _write_source(plan: Plan) -> GeneratedSource:
    """Return the source of all functions of a plan.

    The functions are `constants`, `pass_`, one for each ending that the graph has (`at_stop`, `at_close`), `r1`, `r2`, … for
    the regions below loops and sequences, and `d1`, `d2`, … for shared data nodes. `refresh` computes a shared data node, after
    the stale data nodes on which it depends.
    """
    source = GeneratedSource(f"<graph: {plan.path} #{next(_serial)}>")
    source.add([f"s{data} = 1" for data in plan.flagged])
    source.add([f"l{index} = 0" for index, _ in plan.root.pending])
    _write_constants(plan, source)
    _write_shared(plan, source)
    for region in reversed(plan.regions):  # inner regions first, so that each function is defined above its caller
        _write_region(plan, region, source)
    return source


def _write_constants(plan: Plan, source: GeneratedSource) -> None:
    source.add(["", "def constants():"])
    for refresh in plan.constants:
        source.add(_compute_data(refresh), refresh.node, 1)
    for copy in plan.constant_copies:
        source.add(_copy(copy), copy.target, 1)
    if not plan.constants and not plan.constant_copies:
        source.add(["pass"], None, 1)


def _write_shared(plan: Plan, source: GeneratedSource) -> None:
    """Write one function for each shared data node. The functions do not call each other, so chains may have any length."""
    shared = [refresh for refresh in plan.data.values() if refresh.shared]
    for refresh in shared:
        index = refresh.node
        used = sorted({index, *(copy.source for copy in refresh.copies)})
        bound = [f"c{index}=c{index}", *(f"n{i}=n{i}" for i in used)]
        source.add(["", f"def d{index}({', '.join(bound)}):  # {plan.ids[index]}"])
        source.add([f"global s{index}"], None, 1)
        source.add([*_attempt(_compute_data(refresh), index), f"s{index} = 0"], index, 1)
    if any(_reads_shared(plan, refresh) for refresh in shared):
        table = ", ".join(f"{refresh.node}: d{refresh.node}" for refresh in shared)
        source.add(["", f"def refresh(data, functions={{{table}}}):"])
        source.add(["for index in stale_upstream(data):", "    functions[index]()"], None, 1)


def _reads_shared(plan: Plan, refresh: Refresh) -> bool:
    return any(copy.source in plan.data for copy in refresh.copies)


def _write_region(plan: Plan, region: Region, source: GeneratedSource) -> None:
    """Write the function of a region. With more than `MAX_CALLS` calls, it calls one function for each `MAX_CALLS` calls."""
    name = "pass_" if region.index == 0 else region.ending or f"r{region.index}"
    parts = [region.calls[first : first + MAX_CALLS] for first in range(0, len(region.calls), MAX_CALLS)]
    bodies = [_calls(plan, calls) for calls in parts]
    start = _start(region)
    if len(parts) < 2:
        for body in bodies:
            start.extend(body)
        _write_function(region, name, region.calls, start, region.flags, set(), source)
        return
    uses = [body.variables() for body in (start, *bodies)]
    times = Counter(name for used in uses for name in used)
    shared = {flag for flag in region.flags if times[flag] > 1}
    for number, (calls, body, used) in enumerate(zip(parts, bodies, uses[1:], strict=True)):
        own = [flag for flag in region.flags if flag in used and flag not in shared]
        _write_function(region, f"{name}_part{number}", calls, body, own, shared, source)
        start.add([f"{name}_part{number}()"])
    _write_function(region, name, (), start, sorted(shared), shared, source)


def _start(region: Region) -> GeneratedSource:
    """Return the lines of a region before its calls: the effects of latent nodes, and of the wires that start the region."""
    start = GeneratedSource("")
    start.add(f"s{data} = 1" for data in region.stale)
    for index, branches in region.pending:
        lines = [line for branch in branches for line in _branch(branch, many=True)]
        start.add([f"if l{index}:", f"    p = l{index}", f"    l{index} = 0", *_indented(lines)], index)
    start.add(line for fire in region.entries for line in _fire(fire))
    return start


def _calls(plan: Plan, calls: Iterable[Call]) -> GeneratedSource:
    """Return the lines of some calls of a region."""
    body = GeneratedSource("")
    for guard, guarded in itertools.groupby(calls, key=lambda call: call.guard):
        if guard:
            body.add([f"if {guard}:"])
        for call in guarded:
            indent = 1 if guard else 0
            body.add([f"# {plan.ids[call.node]}"], None, indent)
            _write_call(plan, call, body, indent)
    return body


def _write_function(
    region: Region,
    name: str,
    calls: Iterable[Call],
    body: GeneratedSource,
    flags: Sequence[str],
    shared: Collection[str],
    source: GeneratedSource,
) -> None:
    """Add a function of a region to a source.

    Args:
        region: region of the function.
        name: name of the function.
        calls: calls in the body.
        body: lines of the function.
        flags: flags that the function sets to 0 when it starts.
        shared: flags of the region that are global variables, because several of its functions use them.
        source: source that receives the function.
    """
    used = sorted({index for call in calls for index in _nodes_of(call)})
    ended = {call.node for call in calls if region.ending and call.kind == "event"}  # have the method
    bound = "".join(f", n{i}=n{i}, c{i}={f'n{i}.{region.ending}' if i in ended else f'c{i}'}" for i in used)
    source.add(["", f"def {name}({bound.removeprefix(', ')}):  # {region.title}"])
    variables = sorted(name for name in {*body.variables(), *flags} if name[0] in "sl" or name in shared)
    lines = [f"global {', '.join(variables)}"] if variables else []
    lines += [f"{' = '.join(flags)} = 0"] if flags else []
    lines += [] if body.lines else ["pass"]
    function = GeneratedSource("")
    function.add(lines)
    function.extend(body)
    if region.index:  # another region can have flags with the same names
        renamed = {flag: f"{flag}_r{region.index}" for flag in shared}
        function.lines = [VARIABLE.sub(lambda m: renamed.get(m[0], m[0]), line) for line in function.lines]
    source.extend(function, 1)


def _write_call(plan: Plan, call: Call, source: GeneratedSource, indent: int) -> None:
    """Write code that computes the data nodes that a node reads, and then the node itself: once, or once per activation."""
    for refresh in call.refreshes:
        if not refresh.repeated:
            source.add(_refresh(plan, refresh), refresh.node, indent)
    if not call.activations:
        source.add(_compute(plan, call, {pin.field: pin.counter for pin in call.pins}), call.node, indent)
    for activation in call.activations:
        source.add([f"for _ in range({activation.counter}):"], call.node, indent)
        for refresh in call.refreshes:
            if refresh.repeated:
                source.add(_refresh(plan, refresh), refresh.node, indent + 1)
        source.add(_compute(plan, call, {activation.field: "1"}), call.node, indent + 1)


def _nodes_of(call: Call) -> Iterator[int]:
    """Yield the indices of all nodes whose variables the generated code of a call uses."""
    yield call.node
    for refresh in (*call.refreshes, *(call.rereads or ())):
        if not refresh.shared:
            yield refresh.node
            yield from (copy.source for copy in refresh.copies)
    yield from (copy.source for copy in call.copies)
    yield from (fire.target for branch in call.branches for fire in branch.fires if fire.pending_pin)


# One function a step kind


def _copy(copy: Copy) -> list[str]:
    value = f"n{copy.source}.{copy.source_field}"
    if copy.converter:
        value = f"{copy.converter}({value})"
    place = f"n{copy.target}.{copy.target_field}"
    if not copy.setup:
        return [f"{place} = {value}"]
    return [f"v = {value}", f"if not equal(v, {place}):", f"    {place} = v", "    changed = 1"]


def _copies(copies: Iterable[Copy]) -> list[str]:
    """Return lines that copy values into a node.

    The lines also call `setup_again` if a value that the node reads in `setup` has changed, or if the node's last setup failed.
    """
    copies = list(copies)
    lines = [line for copy in copies for line in _copy(copy)]
    if not any(copy.setup for copy in copies):
        return lines
    return [f"changed = {copies[0].target} in failed", *lines, "if changed:", f"    setup_again({copies[0].target})"]


def _compute_data(refresh: Refresh) -> list[str]:
    return [*_copies(refresh.copies), f"c{refresh.node}()"]


def _refresh(plan: Plan, refresh: Refresh) -> list[str]:
    """Return lines that compute a data node, if needed; if the node raises an exception, its outputs keep their values."""
    index = refresh.node
    if refresh.shared:
        return [f"if s{index}:", f"    refresh({index})" if _reads_shared(plan, refresh) else f"    d{index}()"]
    lines = _attempt(_compute_data(refresh), index)
    if refresh.flagged:
        lines.append(f"s{index} = 0")
    return [f"if s{index}:", *_indented(lines)] if refresh.if_stale else lines


def _fire(fire: FireEffect) -> list[str]:
    if fire.pending_pin:
        return [f"n{fire.target}.{fire.pending_pin} += 1"]
    lines = [f"{fire.guard} = 1"] if fire.guard else []
    return [*lines, f"{fire.counter} += 1"] if fire.counter else lines


def _branch(branch: ExecBranch, *, many: bool) -> list[str]:
    """Return lines that apply the effects of an execution output if the output's bit is set in `p`, the result of `compute`.

    If `many` is false, the node has no other output, and the lines do not mask `p`.
    """
    lines = [line for fire in branch.fires for line in _fire(fire)]
    if branch.region >= 0:
        lines.append(f"r{branch.region}()")
    return [f"if p & {branch.mask}:" if many else "if p:", *_indented(lines)] if lines else []


def _compute(plan: Plan, call: Call, fired: dict[str, str]) -> list[str]:
    """Return lines that call `compute` of a node and fire the returned execution outputs.

    Args:
        plan: plan that contains the call.
        call: call for which to generate code.
        fired: a dict from the field of each execution input to a Python expression for the number of firings; empty if none.
    """
    node = call.node
    before = [*_copies(call.copies), *_tell_pins(call, fired)]
    marks = _marks(plan, call)
    after = [*marks, *(f"n{node}.{pin.field} = 0" for pin in call.pins if pin.pending)]
    if call.kind == "pusher":
        body = [*marks, *(line for branch in call.branches for line in _branch(branch, many=True))]
        if call.rereads is not None:
            body += [line for refresh in call.rereads for line in _refresh(plan, refresh)] + _copies(call.copies)
        loop = [f"for p in c{node}():", *_indented(body or ["pass"])]
        return [*_attempt([*before, *loop], node), *after]
    if call.kind == "latent":
        start = [f"if n{node}.active:", f"    activate({node})"]
        return [*_attempt([*before, f"c{node}()"], node), *after, *start]
    if not call.gated:
        fires = [line for branch in call.branches for fire in branch.fires for line in _fire(fire)]
        return _attempt([*before, f"c{node}()"], node, [*after, *fires], after)
    many = len(call.branches) > 1
    follow = [line for branch in call.branches for line in _branch(branch, many=many)]
    if many and follow:
        follow = ["if p:", *_indented(follow)]
    compute = f"p = c{node}()" if follow else f"c{node}()"
    return _attempt([*before, compute], node, [*after, *follow], after)


def _marks(plan: Plan, call: Call) -> list[str]:
    """Return lines that mark data nodes as stale.

    For more than `MAX_MARKS` data nodes, the lines call `mark_stale` for each data node that reads none of the others.
    """
    if len(call.marks) <= MAX_MARKS:
        return [f"s{data} = 1" for data in call.marks]
    reached = set[int]().union(*(plan.flagged_readers[data] for data in call.marks))
    return [line for d in call.marks if d not in reached for line in (f"if not s{d}:", f"    mark_stale({d})")]


def _tell_pins(call: Call, fired: dict[str, str]) -> list[str]:
    """Return lines that write the number of firings to each execution input of the node, or add the number to a pending pin.

    Args:
        call: call of the node.
        fired: as in `_compute`.
    """
    counts = [(pin, fired.get(pin.field, "")) for pin in call.pins]
    written = [(pin, count) for pin, count in counts if count or not pin.pending]
    return [f"n{call.node}.{pin.field} {'+=' if pin.pending else '='} {count or 0}" for pin, count in written]


def _attempt(lines: list[str], node: int, follow: Sequence[str] = (), otherwise: Sequence[str] = ()) -> list[str]:
    """Return `lines` in a `try` block; `follow` runs after success, `otherwise` after one of the `caught` exceptions."""
    caught = ["except caught as error:", f"    fault({node}, error)", *_indented(otherwise)]
    return ["try:", *_indented(lines), *caught, *(["else:", *_indented(follow)] if follow else [])]


def _indented(lines: Iterable[str]) -> list[str]:
    return [f"    {line}" for line in lines]


def _bounded(node: Node) -> Callable[[], Iterator[int]]:
    """Return a function that acts as `compute` of a loop or sequence node, but raises RuntimeError after `max_pushes` yields."""
    compute, limit = node.compute, type(node).max_pushes

    def pushes() -> Iterator[int]:
        for count, port in enumerate(compute()):
            if count >= limit:
                advice = "to allow more, set `max_pushes` in the node's class"
                raise RuntimeError(f"the node did not end within {limit} iterations; {advice}")
            yield port

    return pushes


def bind_observed(
    plan: Plan, functions: dict[str, Any], computes: Mapping[int, Callable[[], Any]]
) -> Callable[[], None]:
    """Return a second version of `pass_` that calls other functions instead of the `compute` methods of some nodes.

    Args:
        plan: plan of the functions.
        functions: result of `bind`; the second version uses the same nodes and flags.
        computes: function to call instead of `compute`, by node index.
    """
    source, plain = source_of(plan), dict(functions)
    text = _FUNCTIONS.sub(r"observed_\1", source.text)
    functions |= {f"c{index}": compute for index, compute in computes.items()}  # default arguments of the new functions
    exec(compile(text, source.name, "exec"), functions)
    functions |= plain  # the original functions and flags again
    observed: Callable[[], None] = functions["observed_pass_"]
    return observed


def bind(
    plan: Plan,
    nodes: list[Node],
    setup_again: Callable[[int], None],
    activate: Callable[[int], None],
    fault: Callable[[int, Exception], None],
    caught: tuple[type[Exception], ...],
    failed: Container[int],
) -> dict[str, Any]:
    """Execute the generated source of a plan for given nodes; return its global variables: functions, flags and nodes by name.

    Args:
        plan: plan of the nodes' graph.
        nodes: nodes in the order of their indices.
        setup_again: called with a node's index when an input that the node reads in setup has changed.
        activate: called with the index of a latent node that was started.
        fault: called with a node's index and an exception of one of the `caught` types that the node raised.
        caught: types of exceptions after which the pass continues, without the nodes that the failed node would have fired.
        failed: indices of nodes whose last setup failed; these nodes are set up again before they are computed.
    """
    source = source_of(plan)
    namespace: dict[str, Any] = {"setup_again": setup_again, "activate": activate, "fault": fault, "equal": types.equal}
    namespace |= {"caught": caught, "failed": failed}
    namespace |= {"stale_upstream": stale_upstream(plan, namespace), "mark_stale": mark_stale(plan, namespace)}
    namespace |= types.CONVERTERS
    namespace |= {f"n{i}": node for i, node in enumerate(nodes)}
    namespace |= {f"c{i}": _bounded(node) if node.kind() == "pusher" else node.compute for i, node in enumerate(nodes)}
    exec(source.code, namespace)  # generated text: it contains only indices and fields of node classes
    return namespace
