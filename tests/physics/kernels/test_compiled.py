"""Kernels that call parts of other files."""

from __future__ import annotations

import importlib
import linecache
import re
import sys
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("numba")

from graphengine.physics.kernels.compiled import kernel_of
from graphengine.physics.ray_casting.fast import kernel


def test_the_name_of_a_cached_kernel_changes_with_the_modules_of_its_parts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    path, names = tmp_path / "some_parts.py", []
    for factor in (2, 2, 3):
        path.write_text(f"FACTOR = {factor}\n", encoding="utf-8")
        linecache.clearcache()

        def scaled(x: float) -> float:
            return x

        made: Any = kernel_of(importlib.import_module("some_parts"))(scaled)
        names.append(made.py_func.__qualname__)
    assert names[0] == names[1] != names[2]
    assert names[0].startswith("scaled_")


def modules_of(dispatcher: Any) -> set[str]:
    """The modules of all compiled functions that a compiled function calls."""
    function = dispatcher.py_func
    called = [function.__globals__.get(name) for name in function.__code__.co_names]
    return {function.__module__}.union(*(modules_of(each) for each in called if hasattr(each, "py_func")))


def test_the_ray_casting_kernel_names_the_modules_of_all_its_parts() -> None:
    named = re.findall(r"(?m)^@kernel_of\((.*)\)$", Path(kernel.__file__).read_text(encoding="utf-8"))
    called = {name.rpartition(".")[2] for name in modules_of(kernel.cast) - {kernel.__name__}}
    assert called == {"directions", "mesh_walk", "shapes"}
    assert called <= set(named[0].split(", "))
