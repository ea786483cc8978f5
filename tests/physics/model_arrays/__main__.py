"""Stores the arrays of all models of the tests, or stores or compares those of robots in a folder.

python -m tests.physics.model_arrays --write
python -m tests.physics.model_arrays FOLDER --digests FILE [NAME …]

FOLDER holds robot files with their descriptions, as `graphrun new` writes them, or clones of the repositories of public
robots, which are then imported. Each robot file is loaded in a scene, and its description alone in another. If FILE exists,
the models are compared with it; otherwise FILE is written, and the arrays beside it.
"""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import mujoco

from tests.bench.public_descriptions import NEVER_TUNED_TO, ROBOTS
from tests.bench.public_robots import graphrun
from tests.physics.harness import FLOOR
from tests.physics.model_arrays.described import all_described, load, model_of, source_of
from tests.physics.model_arrays.figures import figures
from tests.physics.model_arrays.stored import Figures, Stored, told, write
from tests.physics.model_arrays.test_model_arrays import STORED

ROBOT = re.compile(r"^robot:", re.MULTILINE)
DESCRIPTION = re.compile(r"^(?:urdf|mjcf): *['\"]?([^'\"\n#]+)", re.MULTILINE)
MOST_OF_PUBLIC = 100_000
"""Number of elements up to which an array of a robot in a folder is stored."""


def main() -> int:
    """Store or compare arrays; return 1 if something differs."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.physics.model_arrays", description=__doc__.partition("\n")[0]
    )
    parser.add_argument("folder", type=Path, nargs="?", help="robot files, or clones of public robots")
    parser.add_argument("names", nargs="*", help="parts of the paths of robot files; default: all")
    parser.add_argument("--write", action="store_true", help="renew the stored arrays of the tests")
    parser.add_argument("--digests", type=Path, metavar="FILE", help="file to compare with, or to write")
    given = parser.parse_args()
    if given.write:
        _store_tests()
        return 0
    if given.folder is None or given.digests is None:
        parser.error("give --write, or FOLDER --digests FILE")
    with tempfile.TemporaryDirectory() as scratch:
        return _folder(given.folder.resolve(), given.names, given.digests, Path(scratch))


def _say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def _store_tests() -> None:
    models: dict[str, Figures] = {}
    for described in all_described():
        with tempfile.TemporaryDirectory() as folder:
            models[described.name] = Figures(source_of(described), figures(model_of(described, Path(folder))))
    write(STORED, models)
    sizes = [path.stat().st_size / 1000 for path in (STORED, STORED.with_suffix(".npz"))]
    _say(f"{len(models)} descriptions, {sizes[0]:.0f} kB of digests, {sizes[1]:.0f} kB of arrays")


def _folder(folder: Path, names: list[str], digests: Path, scratch: Path) -> int:
    found = list(_robot_files(folder))
    if not found:
        folder = _imported(folder, scratch)
        found = list(_robot_files(folder))
    old = Stored(digests) if digests.exists() else None
    models, bad = dict[str, Figures](), 0
    for path, description in found:
        name = str(path.relative_to(folder))
        if names and not any(part.lower() in name.lower() for part in names):
            continue
        for kind, uses in (("", {"filed": path}), (" alone", {"bare": description})):
            model = _model(uses, folder, scratch)
            if isinstance(model, str):
                _say(f"{name}{kind}: refused: {model}")
                bad += old is not None and f"{name}{kind}" in old.sources
                continue
            models[f"{name}{kind}"] = Figures("", figures(model))
            if old is None:
                _say(f"{name}{kind}: {model.nbody} bodies, {model.ngeom} geoms, {model.nmesh} meshes")
                continue
            new = f"{name}{kind}" not in old.sources
            differing = [] if new else old.compare(f"{name}{kind}", models[f"{name}{kind}"].arrays, old.of_machine)
            _say(f"{name}{kind}: {'not stored' if new else told(differing, model) or 'equal'}")
            bad += bool(differing)
    if old is None:
        write(digests, models, MOST_OF_PUBLIC)
    _say(
        f"{len(models)} models, {bad} differ" + (" by more than rounding" if old is not None and old.of_machine else "")
    )
    return 1 if bad else 0


def _robot_files(folder: Path) -> Iterator[tuple[Path, Path]]:
    """Yield each robot file below a folder with the description that it names."""
    for path in sorted(folder.rglob("*.yaml")):
        text = path.read_text(encoding="utf-8", errors="replace") if path.is_file() else ""
        named = DESCRIPTION.search(text)
        if ROBOT.search(text) and named is not None:
            yield path, path.parent / named[1].strip()


def _imported(clones: Path, scratch: Path) -> Path:
    """Import the public robots whose clones are in a folder; return a folder with their projects."""
    folder = scratch / "projects"
    folder.mkdir()
    for robot in (*ROBOTS, *NEVER_TUNED_TO):
        if (clones / robot.folder).is_dir():
            arguments = [text.format(repository=clones / robot.folder) for text in robot.arguments]
            source = ["--from", str(clones / robot.folder / robot.file), "--package-path", str(clones)]
            graphrun("new", robot.name.replace(" ", "_").replace("-", "_"), *source, *arguments, folder=folder)
    return folder


def _model(uses: dict[str, Path], folder: Path, scratch: Path) -> mujoco.MjModel | str:
    """Return the compiled model of a scene with these robots; if the scene does not load, return its errors as text."""
    robots = "".join(f'  {name}: {{use: "{path}", position: [0, 0, 2]}}\n' for name, path in uses.items())
    (scratch / "world.xml").write_text(FLOOR, encoding="utf-8")
    (scratch / "scene.yaml").write_text(f"scene: s\nworld: world.xml\nrobots:\n{robots}", encoding="utf-8")
    try:
        return load(scratch / "scene.yaml", folder)
    except ValueError as error:
        return str(error).partition("\n")[0]


if __name__ == "__main__":
    sys.exit(main())
