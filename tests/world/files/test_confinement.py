"""The second wall around xacro: what a confined process cannot do even if an expression got out."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from graphengine.world.files.confinement import ProcessError, ask

CONFINED = """
import os, socket, subprocess, sys, ctypes
from pathlib import Path
from graphengine.files import Files
from graphengine.world.files.confinement import confine
confine(Files((Path({folder!r}),)))
try:
    {attempt}
except BaseException as error:
    sys.stdout.write(f"{{type(error).__name__}}: {{error}}")
else:
    sys.stdout.write("done")
sys.stdout.flush()
os._exit(0)
"""


def confined(attempt: str, folder: Path) -> str:
    code = CONFINED.format(attempt=attempt, folder=str(folder))
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60).stdout


def test_what_may_be_read_is_read(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("a", encoding="utf-8")
    assert confined(f"assert open({str(tmp_path / 'a.txt')!r}).read() == 'a'", tmp_path) == "done"
    assert confined(f"assert os.listdir({str(tmp_path)!r}) == ['a.txt']", tmp_path) == "done"


@pytest.mark.parametrize(
    "attempt",
    [
        "open('/etc/passwd')",
        "os.listdir('/etc')",
        "open('{folder}/../secret')",
        "open('{folder}/new', 'w')",
        "os.open('{folder}/new', os.O_CREAT | os.O_RDWR)",
        "os.remove('{folder}/a.txt')",
        "os.system('touch {folder}/new')",
        "subprocess.run(['true'])",
        "os.fork()",
        "os.kill(os.getppid(), 0)",
        "socket.socket()",
        "ctypes.CDLL(None)",
        "import http.client",
    ],
)
def test_everything_else_is_refused(tmp_path: Path, attempt: str) -> None:
    (tmp_path / "a.txt").write_text("a", encoding="utf-8")
    assert confined(attempt.format(folder=tmp_path), tmp_path).startswith("RefusedError: ")
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


def test_the_environment_is_empty_and_memory_ends(tmp_path: Path) -> None:
    assert confined("assert not os.environ", tmp_path) == "done"
    assert confined("'a' * 10 ** 10", tmp_path).startswith("MemoryError")


@pytest.mark.parametrize(
    ("code", "told"),
    [
        ("import os; os.kill(os.getpid(), 11)", "breaks off: Segmentation fault"),
        ("import os; os.kill(os.getpid(), 9)", "takes more time or memory than it may"),
        ("import time; time.sleep(60)", "takes more than 0.5 s"),
        ("import os, time; os.fork() or time.sleep(60)", "takes more than 0.5 s"),
        ("raise ValueError('this')", "ValueError: this"),
        ("raise SystemExit(3)", "ended with 3"),
    ],
)
def test_a_process_that_does_not_answer_says_why(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: str, told: str
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "answering.py").write_text(f"print('half', flush=True)\n{code}\n", encoding="utf-8")
    with pytest.raises(ProcessError) as caught:
        ask("answering", b"", 0.5 if "sleep" in code else 60)
    assert (str(caught.value), caught.value.answer) == (told, b"half\n")


def test_a_process_sees_no_environment_and_ends_with_its_seconds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("SECRET", "1")
    code = "import os, resource, sys\nfrom graphengine.world.files.confinement import bound\nbound()\n"
    code += "print('SECRET' in os.environ, resource.getrlimit(resource.RLIMIT_CPU), sys.stdin.read())"
    (tmp_path / "telling.py").write_text(code, encoding="utf-8")
    assert ask("telling", b"request", 60) == b"False (20, 20) request\n"
