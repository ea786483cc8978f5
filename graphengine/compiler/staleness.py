"""Functions that the generated code calls to find stale data nodes at run time, in long chains too.

A data node is stale if a data node that it reads is stale. So both searches end at nodes whose flags are already right, and
the time of a pass is proportional to the number of nodes that change.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from graphengine.compiler.plan import Plan


def stale_upstream(plan: Plan, flags: Mapping[str, Any]) -> Callable[[int], list[int]]:
    """Return a function from a stale shared data node to this node and the stale data nodes on which it depends, in order.

    Args:
        plan: plan of the nodes.
        flags: the global variables of the generated functions, which include the flags.
    """
    shared = {index: refresh for index, refresh in plan.data.items() if refresh.shared}
    reads = {
        i: [(c.source, f"s{c.source}") for c in refresh.copies if c.source in shared] for i, refresh in shared.items()
    }

    def find(data: int) -> list[int]:
        found, pending = {data}, [data]
        while pending:
            for source, flag in reads[pending.pop()]:
                if source not in found and flags[flag]:
                    found.add(source)
                    pending.append(source)
        return sorted(found, key=plan.ranks.__getitem__)

    return find


def mark_stale(plan: Plan, flags: dict[str, Any]) -> Callable[[int], None]:
    """Return a function that sets the flags of a data node and of all data nodes that depend on it.

    The arguments are those of `stale_upstream`.
    """
    readers = {f"s{index}": [f"s{reader}" for reader in found] for index, found in plan.flagged_readers.items()}

    def mark(data: int) -> None:
        pending = [f"s{data}"]
        while pending:
            flag = pending.pop()
            flags[flag] = 1
            pending += [reader for reader in readers[flag] if not flags[reader]]

    return mark
