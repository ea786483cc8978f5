"""Mutants: small faults that tests ought to notice, drawn in one revision, and tried in that revision and in later ones.

    python -m tests.bench.mutants draw FILE [--revision R] [--seed N] [--count N]
    python -m tests.bench.mutants run FILE [--revision R] [--files N] [--all]

`draw` writes mutants of all rooms to a JSON file. `run` tries them in a worktree of the revision, with the N files of tests that
are nearest to the module; it adds the first test that fails to the file, and prints a table. Without `--all`, it leaves out
mutants that survived in an earlier revision. A mutant is found by the name of its function and the text of its statement. If it
is gone, write `file`, `function`, `before` and `after` in its `moved`.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import importlib.util
import itertools
import json
import operator
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tests.bench.mutation import KINDS, mutants, places, replaced

REPOSITORY = Path(__file__).resolve().parents[2]
TIMEOUT = "timeout"
SECONDS = 150.0  # of the tests of one mutant
PYTEST = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--tb=no", "-m", "not slow"]
NO_TESTS_OF = re.compile(r"tests/(bench|pictures|docs|third_party)/")

Mutant = dict[str, Any]


def modules(root: Path) -> list[str]:
    """The modules of a checkout."""
    return sorted(str(p.relative_to(root)) for top in ("graphengine", "nodes") for p in (root / top).rglob("*.py"))


def draw(root: Path, seed: int, count: int) -> list[Mutant]:
    """Mutants of all rooms; after two turns, rooms take part by the number of their files. Kinds take turns."""
    chance, of_room, drawn = random.Random(seed), dict[str, list[str]](), list[Mutant]()
    for file in modules(root):
        first, second, *_ = (*Path(file).parts, "")
        if first == "nodes" or not second.endswith(".py"):
            of_room.setdefault("nodes" if first == "nodes" else second, []).append(file)
    rooms = sorted(of_room)
    for number in range(count):
        sizes = [len(of_room[name]) for name in rooms]
        room = chance.choices(rooms, sizes)[0] if number >= 2 * len(rooms) else rooms[number % len(rooms)]
        chance.shuffle(of_room[room])
        for kind, file in itertools.product((*KINDS[number % 5 :], *KINDS[: number % 5]), of_room[room]):
            found = [
                {"room": room, "kind": kind, "file": file, "function": function, "before": before, "after": after}
                for function, body, index in places(ast.parse((root / file).read_bytes()))
                for this, before, after in mutants(body, index)
                if this == kind
            ]
            if found:
                drawn.append({**chance.choice(found), "moved": {}, "results": {}})
                of_room[room].remove(file)
                break
    return drawn


def mutated(root: Path, wanted: Mutant) -> tuple[str, str] | None:
    """The module of a mutant in a checkout, and the module's text with the mutant; None if there is no such statement."""
    parts = {*Path(wanted["file"]).with_suffix("").parts}
    ordered = sorted(modules(root), key=lambda file: -len(parts & {*Path(file).with_suffix("").parts}))
    for function in (wanted["function"], wanted["function"].split(".")[-1]):
        for file in ordered:
            tree = ast.parse((root / file).read_bytes())
            if replaced(tree, function, wanted["before"], wanted["after"]):
                return file, ast.unparse(tree)
    return None


def test_files(root: Path, file: str, function: str) -> list[str]:
    """Files of tests, first those that have the name of a module, import it or an importer of it, or call its function."""
    module, name = Path("graphengine", re.sub("^graphengine/", "", file)).with_suffix(""), function.split(".")[-1]
    stem, dotted = module.name, ".".join(module.parts)
    imported = re.compile(rf"{dotted}\b|{dotted.rpartition('.')[0]} import .*\b{stem}\b")
    using = [other for other in modules(root) if imported.search((root / other).read_text(encoding="utf-8"))]
    importers = re.compile("|".join(other[:-3].replace("/", r"\.") + r"\b" for other in using) or "$^")
    scores: dict[str, float] = {}
    for path in (root / "tests").rglob("test_*.py"):
        test, content = str(path.relative_to(root)), path.read_text(encoding="utf-8")
        beside = sum(itertools.accumulate(map(operator.eq, module.parts[1:], Path(test).parts[1:]), min))
        scores[test] = beside + 4 * (path.stem in (f"test_{stem}", f"test_{module.parent.name}"))
        scores[test] += 3 * bool(imported.search(content)) + 1.5 * bool(importers.search(content))
        scores[test] += 2 * (len(name) > 4 and f"{name}(" in content) + (stem in path.stem)
    return sorted((test for test in scores if not NO_TESTS_OF.match(test)), key=lambda test: (-scores[test], test))


def failing(root: Path, tests: list[str], *options: str, seconds: float | None = None) -> list[str]:
    """The tests that fail, or TIMEOUT."""
    command, environment = [*PYTEST, *options, *tests], {**os.environ, "PYTHONPATH": str(root)}
    with tempfile.TemporaryFile("w+") as output:
        process = subprocess.Popen(command, cwd=root, env=environment, stdout=output, start_new_session=True)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(seconds)
        timeout = process.poll() is None
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        output.seek(0)
        found = re.findall(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", output.read(), re.MULTILINE)
    return [TIMEOUT] if timeout else found


def tried(root: Path, mutant: Mutant, most: int, *options: str) -> str:
    """The first test that fails with a mutant, or TIMEOUT, "survived" or "gone"."""
    wanted = {**mutant, **mutant["moved"]}
    place = mutated(root, wanted)
    if place is None:
        return "gone"
    file, text = place
    names = [test.split("::")[-1].split("[")[0] for test in mutant["results"].values() if "::" in test]
    tests = test_files(root, file, wanted["function"])
    defined = re.compile("|".join(rf"def {name}\(" for name in names) or "$^")
    earlier = [test for test in tests if defined.search((root / test).read_text(encoding="utf-8"))]
    for some, *more in ((earlier, "-k", " or ".join(names)), (tests[:most],)):
        if some:
            with changed(root / file, text):
                failed = failing(root, some, "-x", *more, *options, seconds=SECONDS)
            if failed and (
                failed != [TIMEOUT] or TIMEOUT not in failing(root, some, *more, *options, seconds=SECONDS / 2)
            ):
                return failed[0]
    return "survived"


@contextlib.contextmanager
def changed(module: Path, text: str) -> Iterator[None]:
    """A module with another text. Its bytecode is removed, as a file of the same second and size is not compiled again."""
    before, cached = module.read_bytes(), Path(importlib.util.cache_from_source(str(module)))
    try:
        module.write_text(text, encoding="utf-8")
        cached.unlink(missing_ok=True)
        yield
    finally:
        module.write_bytes(before)
        cached.unlink(missing_ok=True)


@contextlib.contextmanager
def checkout(revision: str) -> Iterator[Path]:
    """A worktree of a revision, outside of the repository."""
    with tempfile.TemporaryDirectory() as folder:
        root, git = Path(folder) / "checkout", ["git", "-C", str(REPOSITORY), "worktree"]
        subprocess.run([*git, "add", "--quiet", "--detach", str(root), revision], check=True)
        try:
            yield root
        finally:
            subprocess.run([*git, "remove", "--force", str(root)], check=True)


def main() -> None:
    """Draw mutants, or try them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("verb", choices=("draw", "run"))
    parser.add_argument("file", type=Path)
    parser.add_argument("--revision", default="HEAD")
    for option, number in (("--seed", 34), ("--count", 60), ("--files", 12)):
        parser.add_argument(option, type=int, default=number)
    parser.add_argument("--all", action="store_true")
    arguments = parser.parse_args()
    file, revision, broken = arguments.file, arguments.revision, set[str]()
    with checkout(revision) as root:
        trying = arguments.verb == "run"
        drawn = json.loads(file.read_text()) if trying else draw(root, arguments.seed, arguments.count)
        while trying:
            for mutant in drawn:
                results = mutant["results"]
                if revision not in results and (arguments.all or "survived" not in results.values()):
                    results[revision] = tried(root, mutant, arguments.files, *(f"--deselect={test}" for test in broken))
                    print(drawn.index(mutant), mutant["file"], results[revision], flush=True)
                    file.write_text(json.dumps(drawn, indent=1), encoding="utf-8")
            died = {test for mutant in drawn if "::" in (test := mutant["results"].get(revision, ""))}
            wrong = {*failing(root, sorted(died))} & died if died else set()
            print("tests that fail without a mutant:", wrong or "none")
            for mutant in drawn:
                if mutant["results"].get(revision) in wrong:
                    del mutant["results"][revision]
            broken |= wrong
            trying = bool(wrong)
    file.write_text(json.dumps(drawn, indent=1), encoding="utf-8")
    for number, m in enumerate(drawn):
        print(f"{number:2}", " | ".join((m["room"], m["kind"], f"{m['file']} {m['function']}", *m["results"].values())))


if __name__ == "__main__":
    main()
