"""Mutants of descriptions through the importer: `python -m tests.bench.fuzz_import DESCRIPTION [--controllers YAML]`.

Each mutant of the description, or of the controllers' YAML if one is given, is imported as `graphrun import-urdf` does; with
`--world`, each mutant of an SDF file is read as the world of a scene. Printed
are exceptions that are no errors of graphengine, imports that take more than `SLOW` seconds, and files that were opened outside
of the folder of the description and the package.
"""

from __future__ import annotations

import argparse
import os
import random
import re
import sys
import sysconfig
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from graphengine.cli import import_urdf, make_parser
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import GraphError
from graphengine.format.files import Files, shipped
from graphengine.format.spec import SceneSpec
from graphengine.format.spec_reader import read
from graphengine.physics.importing.import_robot import import_robot
from graphengine.physics.loading import load_world

SLOW = 5.0
NASTY = (
    *("nan", "inf", "-1", "0", "1e308", "1e-320", "", " ", "-0.0", "99999999999999999999", "true", "[1, 2]", "{a: b}"),
    *("../../../etc/passwd", "/etc/passwd", "file:///etc/passwd", "package://x/y", "$(find x)", "${1/0}"),
    *("model://x", "model://../../etc", "1e16", "-1e16", "1.79769e+308", "world", "__model__", "a::b", "0 0 0 0 0 0"),
    *("&amp;", "\u202e", "\x00", "*a", "!!python/object:x"),
)


def mutated(text: str, dice: random.Random) -> str:
    """Return a text with one or two changes: mostly a value or word exchanged, else lines cut or doubled, or a character."""
    for _ in range(dice.randint(1, 2)):
        way = dice.random()
        values = [match.span() for match in re.finditer(r'(?<=")[^"<>]*(?=")|(?<=>)[^<>]+(?=<)', text)]
        words = [match.span() for match in re.finditer(r"[\w.+-]+", text)] or [(0, len(text))]
        if way < 0.8:
            kind = values if values and way < 0.7 else words
            start, end = dice.choice(kind)
            text = (
                text[:start]
                + (dice.choice(NASTY) if dice.random() < 0.6 else text[slice(*dice.choice(kind))])
                + text[end:]
            )
        elif way < 0.95:
            lines = text.split("\n")
            first = dice.randrange(len(lines))
            last = first + dice.randint(1, 8)
            lines[first:last] = [] if dice.random() < 0.5 else 2 * lines[first:last]
            text = "\n".join(lines)
        else:
            place = dice.randrange(len(text) + 1)
            text = text[:place] + chr(dice.randrange(1, 0x250)) + text[place + 1 :]
    return text


class Opened:
    """Files that this process opens outside of some folders."""

    def __init__(self, *folders: Path) -> None:
        python = {sysconfig.get_paths()[name] for name in ("stdlib", "purelib", "platlib")} | set(sys.path)
        known = (*map(str, folders), *filter(None, python), str(shipped()), "/proc", "/dev")
        self.inside = tuple(os.path.realpath(folder) for folder in known)
        self.outside: Counter[str] = Counter()
        sys.addaudithook(self._hook)

    def _hook(self, event: str, arguments: tuple[object, ...]) -> None:
        if event == "open" and isinstance(arguments[0], str | bytes):
            path = os.path.abspath(os.fsdecode(arguments[0]))
            if not path.startswith(self.inside):
                self.outside[path] += 1


def main() -> None:
    """Import the mutants and print what should not have happened."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("description", type=Path)
    parser.add_argument("--controllers", type=Path)
    parser.add_argument("--world", action="store_true")
    parser.add_argument("--mutants", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    given, more = parser.parse_known_args()
    origin = given.controllers or given.description
    text = origin.read_text(encoding="utf-8")
    outcomes: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as scratch:
        package = next(
            (f for f in given.description.resolve().parents if (f / "package.xml").is_file()), given.description.parent
        )
        opened = Opened(Path(scratch), package)
        mutant = (Path(scratch) if given.controllers else given.description.parent) / f".mutant{origin.suffix}"
        try:
            for number in range(given.mutants):
                mutant.write_text(mutated(text, random.Random(f"{given.seed}/{number}")), encoding="utf-8")
                outcome = _world if given.world else _outcome
                outcomes[outcome(given, mutant, Path(scratch), more, number)] += 1
        finally:
            mutant.unlink(missing_ok=True)
    print(f"{origin.name}: {dict(outcomes)}")
    print(f"opened outside: {dict(opened.outside) or 'nothing'}")


def _outcome(given: argparse.Namespace, mutant: Path, scratch: Path, more: list[str], number: int) -> str:
    """Import one mutant; say how it ended."""
    files = [str(given.description), "--controllers", str(mutant)] if given.controllers else [str(mutant)]
    arguments = make_parser("import-urdf").parse_args(["import-urdf", *files, "-o", str(scratch / "robot.yaml"), *more])
    findings = Findings()

    def attempt() -> bool:
        import_urdf.check_source(arguments)
        source = import_urdf.find_origin(arguments, arguments.output, findings)
        return source is not None and import_robot(source, findings) is not None

    return _tried(attempt, number)


def _world(given: argparse.Namespace, mutant: Path, scratch: Path, more: list[str], number: int) -> str:
    """Load a scene in one mutant of a world; say how it ended."""
    scene, findings = mutant.with_suffix(".yaml"), Findings()
    scene.write_text(f"scene: s\nworld: {mutant.name}\n", encoding="utf-8")

    def attempt() -> bool:
        loaded = read(SceneSpec, scene, findings)
        return loaded is not None and load_world(loaded, Files.of(scene), findings) is not None

    try:
        return _tried(attempt, number)
    finally:
        scene.unlink()


def _tried(attempt: Callable[[], bool], number: int) -> str:
    begin = time.perf_counter()
    try:
        outcome = "imported" if attempt() else "refused"
    except GraphError:
        outcome = "refused"
    except Exception:
        print(f"mutant {number}:\n{traceback.format_exc()}", flush=True)
        outcome = "FAILED"
    if (seconds := time.perf_counter() - begin) > SLOW:
        print(f"mutant {number}: {seconds:.1f} s", flush=True)
    return outcome


if __name__ == "__main__":
    main()
