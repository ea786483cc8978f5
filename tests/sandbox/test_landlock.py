"""Landlock, where this kernel has it: nothing that Python could be talked into is asked."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

RESTRICTED = """
import os, socket, subprocess
from pathlib import Path
from graphengine.sandbox.landlock import available, restrict
able = available()
restrict((Path({folder!r}), Path({folder!r}, "nowhere")))
try:
    {attempt}
except PermissionError:
    print(able, "refused")
else:
    print(able, "done")
"""


def restricted(attempt: str, folder: Path) -> str:
    code = RESTRICTED.format(attempt=attempt.format(folder=folder), folder=str(folder))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    able, outcome = done.stdout.split()
    if able == "False":
        pytest.skip("this kernel has no Landlock")
    return outcome


def test_allowed_files_can_be_read(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("a", encoding="utf-8")
    assert restricted("assert open('{folder}/a.txt').read() == 'a'", tmp_path) == "done"
    assert restricted("assert os.listdir('{folder}') == ['a.txt']", tmp_path) == "done"


@pytest.mark.parametrize(
    "attempt",
    [
        "open('/etc/passwd')",
        "open('/proc/self/environ')",
        "open('{folder}/link')",
        "os.listdir('/etc')",
        "open('{folder}/new', 'w')",
        "open('{folder}/a.txt', 'r+')",
        "os.mkfifo('{folder}/new')",
        "os.symlink('/etc', '{folder}/new')",
        "os.rename('{folder}/a.txt', '{folder}/b.txt')",
        "os.unlink('{folder}/a.txt')",
        "os.execv('/bin/sh', ['sh', '-c', 'true'])",
        "os.posix_spawn('/bin/sh', ['sh', '-c', 'true'], dict())",
    ],
)
def test_the_kernel_refuses_all_other_accesses(tmp_path: Path, attempt: str) -> None:
    (tmp_path / "a.txt").write_text("a", encoding="utf-8")
    (tmp_path / "link").symlink_to("/etc/passwd")
    assert restricted(attempt, tmp_path) == "refused"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.txt", "link"]
