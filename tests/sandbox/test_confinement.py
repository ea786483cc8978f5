"""The second wall around xacro: what a confined process cannot do even if an expression got out."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from graphengine.sandbox.borders import missing
from graphengine.sandbox.confinement import ProcessError, ask
from graphengine.sandbox.seccomp import TIERS

IMPORTS = """
import ctypes, json, os, resource, socket, subprocess, sys, threading, time
from pathlib import Path
from graphengine.format.files import Files
from graphengine.sandbox import confinement
from graphengine.sandbox.confinement import bound, confine
from graphengine.sandbox.seccomp import TIERS
"""
CONFINED = """
confine(Files((Path({folder!r}),)), TIERS["xacro"])
try:
    {attempt}
except BaseException as error:
    sys.stdout.write(f"{{type(error).__name__}}: {{error}}")
else:
    sys.stdout.write("done")
sys.stdout.flush()
os._exit(0)
"""


def run(code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", IMPORTS + code], capture_output=True, text=True, timeout=60)


def confined(attempt: str, folder: Path) -> str:
    done = run(CONFINED.format(attempt=attempt, folder=str(folder)))
    done.check_returncode()
    return done.stdout


def test_allowed_files_can_be_read(tmp_path: Path) -> None:
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
def test_all_other_accesses_are_refused(tmp_path: Path, attempt: str) -> None:
    (tmp_path / "a.txt").write_text("a", encoding="utf-8")
    assert confined(attempt.format(folder=tmp_path), tmp_path).startswith("AccessDeniedError: ")
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


UNJUDGED = """
confinement.check_readable = lambda *_: None
confinement.confine(Files((Path({folder!r}), Path({share!r})), installed=(Path({share!r}),)), TIERS[{tier!r}])
found = {{}}
for name in {names!r}:
    try:
        open(name).close()
    except OSError as error:
        found[name] = type(error).__name__
    else:
        found[name] = "read"
sys.stdout.write(json.dumps(found))
sys.stdout.flush()
os._exit(0)
"""


@pytest.mark.skipif(bool(missing()), reason="this machine lacks a border")
@pytest.mark.parametrize("tier", TIERS)
def test_the_kernel_allows_reading_named_packages_and_the_targets_of_their_links(tier: str, tmp_path: Path) -> None:
    places = ["own", "source/cart/meshes", "source/other", "share/cart", "share/other"]
    for place in places:
        (tmp_path / place).mkdir(parents=True)
        (tmp_path / place / "a").write_text("a", encoding="utf-8")
    (tmp_path / "share/cart/meshes").symlink_to(tmp_path / "source/cart/meshes")
    (tmp_path / "share/cart/b").symlink_to(tmp_path / "source/cart/meshes/a")
    files = [*(f"{place}/a" for place in places), "share/cart/meshes/a", "share/cart/b"]
    names = [f"{tmp_path}/{file}" for file in files]
    folders = {"folder": str(tmp_path / "own"), "share": str(tmp_path / "share/cart")}
    done = run(UNJUDGED.format(**folders, names=names, tier=tier))
    read = {"own/a", "source/cart/meshes/a", "share/cart/a", "share/cart/meshes/a", "share/cart/b"}
    expected = ["read" if file in read and tier != "mesh" else "PermissionError" for file in files]
    assert json.loads(done.stdout) == dict(zip(names, expected, strict=True))


def test_a_kernel_feature_that_cannot_be_enabled_ends_the_process() -> None:
    """Landlock binds one thread, so that another one would run without it."""
    starting = "threading.Thread(target=time.sleep, args=[1], daemon=True).start()"
    done = run(f"{starting}\nconfine(Files(()), TIERS['script'])")
    assert done.returncode == 1
    assert "Landlock restricts only one thread, but 2 are running" in done.stderr


def test_a_confined_process_has_no_open_files_but_its_pipes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "telling.py").write_text("import os\nprint(sorted(os.listdir('/proc/self/fd')))", encoding="utf-8")
    with open("/etc/passwd") as file:
        os.set_inheritable(file.fileno(), True)
        assert ask("telling", b"", 60) == b"['0', '1', '2', '3']\n"  # the last is the listing's own


ENDING = """
confine(Files(()), TIERS["script"])
os.write({word}, b"up")
time.sleep(30)
os.write({word}, b"late")
os._exit(0)
"""


@pytest.mark.skipif(bool(missing()), reason="this machine lacks a border")
def test_a_confined_process_ends_with_its_parent() -> None:
    reader, writer = os.pipe()
    child = [sys.executable, "-c", IMPORTS + ENDING.format(word=writer)]
    launch = f"import subprocess\nsubprocess.run({child!r}, pass_fds=[{writer}])"
    parent = subprocess.Popen([sys.executable, "-c", launch], pass_fds=[writer], stdout=subprocess.PIPE)
    os.close(writer)
    assert os.read(reader, 2) == b"up"
    parent.kill()
    assert os.read(reader, 4) == b""
    os.close(reader)
    parent.communicate()


@pytest.mark.skipif(bool(missing()), reason="this machine lacks a border")
def test_a_process_whose_parent_ended_before_the_confinement_ends_too() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-c", IMPORTS + ENDING.format(word=2)]
    done = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE)
    os.close(writer)
    assert (done.returncode, done.stderr) == (1, b"")


@pytest.mark.skipif(bool(missing()), reason="this machine lacks a border")
def test_the_number_of_threads_is_limited_for_root_too() -> None:
    code = "events = ['_thread.start_new_thread', '_thread.start_joinable_thread']\n"
    code += "confinement.MAX_THREADS = 1\nconfinement.confine(Files(()), TIERS['script'], also=events)\n"
    code += "threading.Thread(target=print).start()"
    done = run(code)
    assert "can't start new thread" in done.stderr


def test_a_confined_process_queues_no_signals(tmp_path: Path) -> None:
    assert confined("assert resource.getrlimit(resource.RLIMIT_SIGPENDING) == (0, 0)", tmp_path) == "done"


def test_a_confined_process_has_no_environment_variables_and_limited_memory(tmp_path: Path) -> None:
    assert confined("assert not os.environ", tmp_path) == "done"
    assert confined("'a' * 10 ** 10", tmp_path).startswith("MemoryError")


@pytest.mark.parametrize(
    ("code", "told"),
    [
        ("import os; os.kill(os.getpid(), 11)", "crashed: Segmentation fault"),
        ("import os; os.kill(os.getpid(), 9)", "exceeds its limit of CPU time or memory"),
        ("raise ValueError('this')", "ValueError: this"),
        ("raise SystemExit(3)", "ended with exit code 3"),
    ],
)
def test_a_process_that_fails_is_an_error_with_its_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: str, told: str
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "answering.py").write_text(f"print('half', flush=True)\n{code}\n", encoding="utf-8")
    with pytest.raises(ProcessError) as caught:
        ask("answering", b"", 60)
    assert (str(caught.value), caught.value.answer) == (told, b"half\n")


@pytest.mark.parametrize("code", ["time.sleep(600)", "import os; os.fork() or time.sleep(600)"])
def test_a_process_that_takes_too_long_is_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: str) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "answering.py").write_text(f"print('half', flush=True)\nimport time\n{code}\n", encoding="utf-8")
    for seconds in (0.5, 5, 50):  # a busy machine may not have started it sooner
        with pytest.raises(ProcessError) as caught:
            ask("answering", b"", seconds)
        assert str(caught.value) == f"takes more than {seconds} s"
        if caught.value.answer:
            break
    assert caught.value.answer == b"half\n"


def test_a_process_gets_no_environment_variables_and_ends_at_its_time_limit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("SECRET", "1")
    code = f"{IMPORTS}bound()\n"
    code += "print('SECRET' in os.environ, resource.getrlimit(resource.RLIMIT_CPU), sys.stdin.read())"
    (tmp_path / "telling.py").write_text(code, encoding="utf-8")
    assert ask("telling", b"request", 60) == b"False (20, 20) request\n"


BOOTSTRAPPER = """
import os, sys
with open({starts!r}, "a") as file:
    file.write("start\\n")
if not os.environ.get("_ROS_WHEELS_BOOTSTRAP_COMPLETE"):
    os.execve(sys.executable, sys.orig_argv, os.environ | {{"_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1"}})
"""
"""What the wheels of ROS 2 from PyPI do at each start of Python, with a file that counts the starts."""


def test_the_wheels_of_ros_do_not_restart_a_confined_process(tmp_path: Path) -> None:
    starts, venv = tmp_path / "starts", tmp_path / "venv"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(venv)], check=True)
    (site,) = venv.glob("lib/python*/site-packages")
    (site / "bootstrapper_of_wheels.py").write_text(BOOTSTRAPPER.format(starts=str(starts)), encoding="utf-8")
    (site / "bootstrapper.pth").write_text("import bootstrapper_of_wheels\n", encoding="utf-8")
    asking = "from graphengine.sandbox.confinement import ask; print(ask('platform', b'', 60).decode())"
    environment = {name: value for name, value in os.environ.items() if name != "_ROS_WHEELS_BOOTSTRAP_COMPLETE"}
    environment["PYTHONPATH"] = os.pathsep.join(filter(None, sys.path))
    done = subprocess.run(
        [venv / "bin" / "python", "-c", asking], env=environment, capture_output=True, text=True, timeout=60
    )
    assert "Linux" in done.stdout, done.stderr
    outer, confined = 2, 1
    assert starts.read_text(encoding="utf-8").count("start") == outer + confined
