"""Mutants of small stages: `python -m tests.descriptions.usd.fuzz 10000 --kind usda` reads as many and prints what went wrong.

Each mutant is read in a process of its own, forked from one that has loaded USD's library and then confined like the real one.
What it answers becomes a robot in a second one. Nothing may raise, hang, or open a file that it may not read.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import re
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from pxr import Sdf, Usd

from graphengine.descriptions.link_tree import MAX_LINKS
from graphengine.descriptions.usd import usd_reader
from graphengine.descriptions.usd.layers import confined
from graphengine.descriptions.usd.prim_spans import PrimSpans
from graphengine.descriptions.usd.stage_physics_process import PhysicsReading
from graphengine.descriptions.usd_model import PhysicsContents
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files
from graphengine.sandbox.confinement import ProcessError
from graphengine.sandbox.untrusted import encoded, read
from tests.descriptions.usd.stages import arm, rover, workshop

PATIENCE = 20
"""Time for one mutant, s."""
SECRET = "the secret of another folder"
_PIECES = (
    *(
        "inf",
        "-inf",
        "nan",
        "0",
        "-1",
        "1e38",
        "1e-38",
        "999999999",
        "true",
        '"x"',
        "[]",
        "None",
        "(0, 0, 0)",
        "</World>",
        "</>",
    ),
    *(
        "@../secret.usda@",
        "@/etc/passwd@",
        "@https://example.org/a.usd@",
        "@./stage.usda@",
        "references",
        "payload",
        "over",
        "class",
    ),
    *(
        "{",
        "}",
        "(",
        ")",
        "[",
        "]",
        '"',
        "timeSamples",
        "instanceable = true",
        "PhysicsRigidBodyAPI",
        "PhysicsFixedJoint",
        "Mesh",
    ),
)


_NUMBER, _WORD = re.compile(rb"-?\b\d+(?:\.\d+)?(?:e-?\d+)?\b"), re.compile(rb"\b[A-Za-z_][A-Za-z_0-9:]{2,}\b")
_NUMBERS = ("0", "-1", "1e38", "1e-38", "inf", "-inf", "nan", "3.4e38", "1e-9", "2147483648", "-0", "1e300")


def mutant(data: bytes, dice: random.Random, *, binary: bool) -> bytes:
    """Return a copy of a file in which some pieces are changed, removed, doubled or swapped."""
    if not binary and dice.random() < 0.7:  # a value or a name changes, so that the file is still USD
        kind = dice.choice((_NUMBER, _NUMBER, _WORD))
        made = bytearray(data)
        for _ in range(dice.choice((1, 2, 5))):
            found = list(kind.finditer(made))
            one, value = dice.choice(found), bytes(dice.choice(found)[0])
            value = dice.choice((value, dice.choice(_NUMBERS).encode())) if kind is _NUMBER else value
            made[one.start() : one.end()] = value
        return bytes(made)
    made = bytearray(data)
    for _ in range(dice.choice((1, 1, 2, 4, 16))):
        start = dice.randrange(len(made))
        size = dice.choice((1, 2, 4, 8, 40))
        match dice.randrange(6):
            case 0:
                made[start : start + size] = b""
            case 1:
                made[start:start] = made[start : start + size]
            case 2 if binary:
                made[start] ^= 1 << dice.randrange(8)
            case 2:
                made[start : start + size] = dice.choice(_PIECES).encode()
            case 3 if not binary:
                words = bytes(made).split()
                word = dice.choice(words)
                made = bytearray(bytes(made).replace(word, dice.choice((*words, *(p.encode() for p in _PIECES))), 1))
            case 4:
                other = dice.randrange(len(made))
                made[start : start + size], made[other : other + size] = (
                    made[other : other + size],
                    made[start : start + size],
                )
            case _:
                made[start] = dice.randrange(256)
        if not made:
            return data
    return bytes(made)


def forked(work: Callable[[int], None]) -> tuple[int, bytes]:
    """Run a function in a forked process with a pipe; return how it ended (0, or the number of its signal) and what it wrote."""
    readable, writable = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(readable)
        signal.alarm(PATIENCE)
        try:
            work(writable)
        except BaseException as error:
            frames = [f"{frame.f_code.co_filename}:{line}" for frame, line in traceback.walk_tb(error.__traceback__)]
            os.write(writable, f"TRACE {type(error).__name__} {error} {' '.join(frames[-3:])}".encode())
            os._exit(1)
        os._exit(0)
    os.close(writable)
    with os.fdopen(readable, "rb") as stream:
        said = stream.read()
    status = os.waitpid(child, 0)[1]
    return os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0, said


def judge(path: Path) -> str:
    """Return what happens to a stage: `robot`, `refused`, `crashed`, or what went wrong, beginning with `!`."""
    files = Files.of(path)

    def reading(writable: int) -> None:
        quiet = os.open(os.devnull, os.O_WRONLY)
        os.dup2(quiet, 1)
        os.dup2(quiet, 2)
        with os.fdopen(writable, "w", closefd=False) as stream:
            confined(files)
            stream.write(encoded(PhysicsReading(files).run(path)))
            stream.flush()
            os._exit(0)

    ended, said = forked(reading)
    if ended == signal.SIGALRM:  # a fork may inherit a lock of USD's library; the real process starts anew
        before = time.monotonic()
        usd_reader.read_usd(path, files, Findings())
        return (
            "! hangs" if time.monotonic() - before > usd_reader.MAX_SECONDS + PATIENCE else "ended by the limit of time"
        )
    if ended or not said:
        return f"crashed by signal {ended}"
    if said.startswith(b"TRACE"):
        return f"! {said.decode()}"
    if SECRET.encode() in said or b"root:x:" in said:
        return "! reads outside"

    def making(writable: int) -> None:
        findings = Findings()
        try:
            contents = read(said, PhysicsContents, usd_reader.MAX_ANSWER)
        except ProcessError:
            os.write(writable, b"refused")
            return
        spans = PrimSpans(path)
        if contents.failure or len(contents.bodies) > MAX_LINKS:
            os.write(writable, b"refused")
            return
        tree = usd_reader.chosen(contents, "", spans, findings)
        made = usd_reader.description_of(contents, tree, path, files, findings) if tree is not None else None
        os.write(writable, b"robot" if made is not None else b"refused")

    ended, said = forked(making)
    if said.startswith(b"TRACE"):
        return f"! {said.decode()}"
    return f"! ends by signal {ended}" if ended else said.decode()


def run(count: int, kind: str, seed: int, folder: Path) -> Counter[str]:
    """Read mutants, and return how many had each outcome."""
    dice, outside = random.Random(seed), folder / "secret.usda"
    outside.write_text(
        f'#usda 1.0\ndef "Secret" (doc = "{SECRET}") {{\n string isaac:namespace = "{SECRET}"\n}}\n', encoding="utf-8"
    )
    home = folder / "stranger"
    home.mkdir()
    originals = [make(home / f"{make.__name__}.usda") for make in (rover, arm, workshop)]
    if kind == "usdc":
        for each in originals:
            Sdf.Layer.FindOrOpen(str(each)).Export(str(each.with_suffix(".usdc")))
    data = [each.with_suffix(f".{kind}").read_bytes() for each in originals]
    assert Usd.Stage.Open(str(originals[0]))
    found: Counter[str] = Counter()
    for number in range(count):
        path = home / f"stage.{kind}"
        path.write_bytes(mutant(dice.choice(data), dice, binary=kind == "usdc"))
        outcome = judge(path)
        found[outcome] += 1
        if outcome.startswith("!"):
            kept = Path(tempfile.gettempdir()) / f"mutant_{seed}_{number}.{kind}"
            kept.write_bytes(path.read_bytes())
            sys.stderr.write(f"{kept}: {outcome}\n")
    return found


def main() -> None:
    """Read the mutants that the command line asks for."""
    parser = argparse.ArgumentParser()
    parser.add_argument("count", type=int)
    parser.add_argument("--kind", choices=("usda", "usdc"), default="usda")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        found = run(arguments.count, arguments.kind, arguments.seed, Path(folder))
    sys.stdout.write(f"{json.dumps(found)}\n")


if __name__ == "__main__":
    main()
