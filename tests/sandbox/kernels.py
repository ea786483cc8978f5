"""Kernels that lack a border, as a process and its children see them: a filter gives the answer of a kernel without it."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from graphengine.sandbox.borders import BORDERS

ROOT = Path(__file__).resolve().parents[2]

_CALLS = {"Landlock": 444, "seccomp": {"x86_64": 317, "aarch64": 277}.get(os.uname().machine, 317)}
_LACKING = """
import ctypes, runpy, struct, sys
calls = [int(word) for word in sys.argv[1].split(",") if word]
lines = [(0x20, 0, 0, 0)]
for call in calls:
    lines += [(0x15, 0, 1, call), (6, 0, 0, 0x50026)]
lines.append((6, 0, 0, 0x7FFF0000))
text = ctypes.create_string_buffer(b"".join(struct.pack("<HBBI", *line) for line in lines))
program = ctypes.create_string_buffer(struct.pack("<HxxxxxxQ", len(lines), ctypes.addressof(text)))
libc = ctypes.CDLL(None, use_errno=True)
assert libc.prctl(38, 1, 0, 0, 0) == 0 and libc.prctl(22, 2, program, 0, 0) == 0, ctypes.get_errno()
sys.argv[:] = sys.argv[2:]
exec(sys.argv[0])
"""


def run(code: str, lacking: Sequence[str], *arguments: str) -> subprocess.CompletedProcess[str]:
    """What Python code does where the kernel lacks some borders: their system calls fail with ENOSYS."""
    assert set(lacking) <= set(BORDERS)
    calls = ",".join(str(_CALLS[name]) for name in lacking)
    command = [sys.executable, "-c", _LACKING, calls, code, *arguments]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(command, capture_output=True, text=True, timeout=300, env=environment)
