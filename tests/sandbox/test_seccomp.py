"""seccomp: in each tier the kernel allows the system calls that the manual lists, and refuses all others."""

from __future__ import annotations

import errno
import json
import os
import platform
import re
import signal
import struct
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

from graphengine.format.files import shipped
from graphengine.sandbox import seccomp
from graphengine.sandbox.seccomp import TIERS, compose, numbers

needs_seccomp = pytest.mark.skipif(not seccomp.available(), reason="this machine has no seccomp")

HEADERS = {
    "x86_64": ("/usr/include/x86_64-linux-gnu/asm/unistd_64.h", "/usr/include/asm/unistd_64.h"),
    "aarch64": ("/usr/include/asm-generic/unistd.h",),
}
HIGHEST = 600
PROBES = (335, 336) if platform.machine() == "x86_64" else ()
"""uretprobe and uprobe, which Linux passes by filters: they end whoever calls them but from the kernel's own trampoline."""
FOREIGN = 0x40000000

Arguments = tuple[int | str, ...]

ASKING = """
import ctypes, json, os, struct, sys
from pathlib import Path
from graphengine.format.files import Files
from graphengine.sandbox.confinement import confine
from graphengine.sandbox.seccomp import TIERS
from graphengine.sandbox.system_calls import call, renounce_privileges
wanted = json.load(sys.stdin)
# a filter that stops calls with a certain last argument before they are made: with ENOSYS, over which a refusal takes precedence
filter = [(0x20, 0, 0, 56), (0x15, 0, 1, 0x5EC), (6, 0, 0, 0x7FF00000), (6, 0, 0, 0x7FFF0000)]
text = ctypes.create_string_buffer(b"".join(struct.pack("<HBBI", *line) for line in filter), 32)
program = ctypes.create_string_buffer(struct.pack("<HxxxxxxQ", 4, ctypes.addressof(text)), 16)
renounce_privileges()
assert ctypes.CDLL(None).prctl(22, 2, program, 0, 0) == 0
function = ctypes.CDLL(None, use_errno=True).syscall
function.restype = ctypes.c_long
def ask(number, *given):
    ctypes.set_errno(0)
    assert function(*(ctypes.c_long(value) for value in (number, *given, *[0] * (5 - len(given)), 0x5EC))) == -1
    return ctypes.get_errno()
assert ask(39) == 38
confine(Files((Path("/"),)), TIERS[sys.argv[1]], also=("ctypes.set_errno", "ctypes.get_errno"))
own = os.getpid()
answer = json.dumps([ask(*(own if value == "own" else value for value in call)) for call in wanted])
sys.stdout.write(answer)
sys.stdout.flush()
os._exit(0)
"""


def ask(tier: str, calls: Sequence[tuple[int | str, ...]]) -> list[int]:
    """The error of each call in a confined process: ENOSYS where it would be made, as another filter stops it then."""
    command = [sys.executable, "-c", ASKING, tier]
    done = subprocess.run(command, input=json.dumps(calls), capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return list(json.loads(done.stdout))


def header(machine: str) -> dict[str, int]:
    path = next(filter(os.path.exists, HEADERS[machine]), None)
    if path is None:
        pytest.skip("the headers of the kernel are not installed")
    text = Path(path).read_text(encoding="ascii")
    return {name: int(number) for name, number in re.findall(r"^#define __NR(?:3264)?_(\w+)\s+(\d+)", text, re.M)}


def by_name() -> dict[str, int]:
    return {name: number for part in numbers(platform.machine()) for name, number in part.items()}


def listed(tier: str) -> set[str]:
    """Names of the calls that the manual lists for a tier."""
    text = (shipped() / "docs" / "how" / "security.md").read_text(encoding="utf-8")
    (row,) = re.findall(rf"^\| {tier} \| .* \| ([\w, ]+) \|$", text, re.M)
    parts = {kind.lower(): set(names.split()) for kind, names in re.findall(r"^(\w+): `([\w\s]+)`$", text, re.M)}
    return set().union(*(parts[kind] for kind in row.split(", ")))


@pytest.mark.parametrize("machine", HEADERS)
def test_call_numbers_equal_those_in_the_kernel_headers(machine: str) -> None:
    known = header(machine)
    known.setdefault("newfstatat", known.get("fstatat", -1))
    names = set().union(*numbers(machine))
    assert {name: known[name] for name in names} == {k: v for part in numbers(machine) for k, v in part.items()}
    assert not {name for name in set().union(*numbers("x86_64")) - names if name in known}


@needs_seccomp
@pytest.mark.parametrize("tier", TIERS)
def test_each_tier_allows_exactly_the_system_calls_that_the_manual_lists(tier: str) -> None:
    """With arguments that fit the calls that are allowed with some only; nothing is executed."""
    names = {number: name for name, number in by_name().items()}
    fitting: dict[str, Arguments] = {"clone": (0x3D0F00,), "fcntl": (0, 1), "ioctl": (0, 0x5401), "tgkill": ("own",)}
    every = [number for number in range(HIGHEST + 1) if number not in PROBES]
    every += [*range(FOREIGN, FOREIGN + HIGHEST), (1 << 31) - 1, 1 << 31, (1 << 32) - 1]
    answers = ask(tier, [(number, *fitting.get(names.get(number, ""), ())) for number in every])
    assert set(answers) == {errno.EPERM, errno.ENOSYS}
    allowed = (number for number, code in zip(every, answers, strict=True) if code != errno.EPERM)
    passed = {names.get(number, str(number)) for number in allowed}
    known = {name for name in listed(tier) if name in by_name()}
    files, threads = TIERS[tier]
    assert passed == known | ({"openat2"} if files else set()) | ({"clone3"} if threads else set())


NULL, HERE = 0, -100
WRITING = (1, 2, 3, 0o100, 0o1000, 0o2000, os.O_TMPFILE, os.O_PATH)
DANGEROUS: list[tuple[str, Arguments, int]] = [
    *((("openat", (HERE, NULL, flags), errno.EPERM)) for flags in WRITING),
    ("openat", (HERE, NULL, os.O_RDONLY | os.O_CLOEXEC | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_NONBLOCK), errno.ENOSYS),
    ("openat", (HERE, NULL, 1 << 32), errno.ENOSYS),  # the kernel takes an int
    ("clone", (17,), errno.EPERM),
    ("clone", (0,), errno.EPERM),
    ("clone", (0x4111,), errno.EPERM),  # as vfork
    ("clone", (0x3D0F00 | 0x40000000,), errno.EPERM),  # in a network of its own
    ("clone", (0x3D0F00 | 0x8000,), errno.EPERM),  # as a child of the parent
    ("madvise", (0, 0, 4), errno.ENOSYS),
    ("madvise", (0, 0, 100), errno.EPERM),  # MADV_HWPOISON
    ("madvise", (0, 0, 12), errno.EPERM),  # MADV_MERGEABLE
    ("tgkill", (1,), errno.EPERM),
    ("tgkill", (-1,), errno.EPERM),
    ("tgkill", (0,), errno.EPERM),
    ("prlimit64", (0, 7, NULL), errno.ENOSYS),
    ("prlimit64", (0, 7, 4096), errno.EPERM),
    ("prlimit64", (0, 7, 1 << 32), errno.EPERM),
    ("prlimit64", (1, 7, NULL), errno.EPERM),
    *((("fcntl", (1, command), errno.EPERM)) for command in (4, 5, 6, 7, 8, 10, 15, 37, 38, 1024, 1026, 1031, 1033)),
    *((("ioctl", (0, command), errno.EPERM)) for command in (0x5412, 0x5402, 0x540E, 0x5421, 0x5452, 0x541C, 0x8901)),
    ("ioctl", (0, (1 << 32) | 0x5412), errno.EPERM),
]
"""Calls that change something outside with some arguments: lasting names, other processes, terminals."""


@needs_seccomp
def test_system_calls_with_dangerous_arguments_are_refused() -> None:
    known = by_name()
    answers = ask("script", [(known[name], *given) for name, given, _ in DANGEROUS])
    assert list(zip(DANGEROUS, answers, strict=True)) == [(case, case[2]) for case in DANGEROUS]


@pytest.mark.parametrize("machine", ["x86_64", "aarch64"])
@pytest.mark.parametrize("tier", TIERS)
def test_the_filters_of_both_architectures_make_equal_decisions(machine: str, tier: str) -> None:
    """By an interpreter of the five instructions, for the machine that this is not."""
    names = {number: name for part in numbers(machine) for name, number in part.items()}
    program = compose(machine, TIERS[tier], 4242)
    answers = {number: run(program, machine, number, 4242) for number in range(HIGHEST)}
    allowed = {names[number] for number, answer in answers.items() if answer == 0x7FFF0000}
    expected = listed(tier) & set(names.values())
    assert allowed == expected - {"clone", "ioctl"}  # which all zeros are no arguments for
    assert run(program, machine, 0, 4242, architecture=0x40000003) == 0x80000000


def run(program: bytes, machine: str, number: int, first: int, architecture: int | None = None) -> int:
    """What a filter returns for a call whose first argument fits `tgkill`, all others being zero."""
    first = first if number == {"x86_64": 234, "aarch64": 131}[machine] else 0
    architecture = seccomp.ARCHITECTURES[machine] if architecture is None else architecture
    data = struct.pack("<IIQQQQQQQ", number, architecture, 0, first, 0, 0, 0, 0, 0)
    code, at, value = list(struct.iter_unpack("<HBBI", program)), 0, 0
    while True:
        instruction, yes, no, k = code[at]
        at += 1
        if instruction == 0x20:
            (value,) = struct.unpack_from("<I", data, k)
        elif instruction == 0x54:
            value &= k
        elif instruction == 0x06:
            return int(k)
        else:
            at += yes if (value == k if instruction == 0x15 else value >= k) else no


FOREIGN_CALL = """
import ctypes, mmap, os, sys
from graphengine.sandbox.seccomp import TIERS, restrict
page = mmap.mmap(-1, 4096, prot=7)
page.write(bytes.fromhex("b814000000cd80c3"))  # mov eax, 20; int 0x80; ret: getpid of i386
ask = ctypes.CFUNCTYPE(ctypes.c_int)(ctypes.addressof(ctypes.c_char.from_buffer(page)))
if "confined" in sys.argv:
    restrict(TIERS["script"])
os._exit(ask() != os.getpid())
"""


@needs_seccomp
@pytest.mark.skipif(platform.machine() != "x86_64", reason="there is one architecture")
def test_calls_of_another_architecture_end_the_process() -> None:
    command = [sys.executable, "-c", FOREIGN_CALL]
    free, confined = (subprocess.run([*command, word]).returncode for word in ("", "confined"))
    if free != 0:
        pytest.skip("this kernel has no calls of i386")
    assert confined == -signal.SIGSYS


def test_a_confined_process_keeps_at_most_the_capability_to_read_files() -> None:
    code = "from graphengine.sandbox.system_calls import renounce_privileges\nrenounce_privileges()\n"
    code += "print(*(line.split()[1] for line in open('/proc/self/status') if line.startswith(('CapEff', 'CapPrm', 'NoNew'))))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    permitted, effective, locked = done.stdout.split()
    assert {int(permitted, 16), int(effective, 16)} <= {0, 1 << 2}
    assert locked == "1"
