"""Stores the arrays of models, and compares models with them.

A JSON file has the digest of every array, and an npz file beside it the arrays themselves, except large ones.
"""

from __future__ import annotations

import io
import itertools
import json
import zipfile
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from tests.physics.model_arrays.differences import OF_MACHINE, Difference, differences
from tests.physics.model_arrays.figures import Array, digests
from tests.physics.model_arrays.machine import probe

LARGEST = 10_000
"""Number of elements up to which an array is stored; of a larger one, only the digest is."""


@dataclass(frozen=True)
class Figures:
    """The arrays of a model by name, and a digest of the files that it is made from."""

    source: str
    arrays: Mapping[str, Array]


class Stored:
    """The stored arrays.

    Attributes:
        mujoco: version of MuJoCo that made them.
        probe: what the machine that made them computes; see `machine.probe`.
        sources: digests of the files of each description, by its name.
        of_machine: names of the arrays whose last bits depend on the machine; empty on a machine like the one that made them.
    """

    def __init__(self, path: Path) -> None:
        document = json.loads(path.read_text(encoding="utf-8"))
        self.mujoco: str = document["mujoco"]
        self.probe: str = document["probe"]
        self.of_machine: Collection[str] = () if probe() == self.probe else OF_MACHINE
        self.sources: dict[str, str] = document["descriptions"]
        self._columns: dict[str, tuple[str, list[str]]] = {
            name: (usual, row.split(",")) for name, (usual, row) in document["arrays"].items()
        }
        self._rows = {name: row for row, name in enumerate(self._columns)}
        with np.load(path.with_suffix(".npz")) as file:
            self._flat: dict[str, Array] = dict(file)
        self._sizes = self._flat["sizes"]

    def digests(self, description: str) -> dict[str, str]:
        """Return the digest of each array of a description by name."""
        index = list(self.sources).index(description)
        return {name: row[index] or usual for name, (usual, row) in self._columns.items()}

    def array(self, description: str, name: str) -> Array | None:
        """Return the elements of an array in one dimension; None if it is not stored."""
        index, row = list(self.sources).index(description), self._rows.get(name)
        sizes = self._sizes[row] if row is not None else None
        if sizes is None or sizes[index] < 0:
            return None
        start = int(np.maximum(sizes[:index], 0).sum())
        return self._flat[name][start : start + int(sizes[index])]

    def compare(self, description: str, arrays: Mapping[str, Array], rounded: Collection[str] = ()) -> list[Difference]:
        """Return the differences of a model from the stored one.

        Args:
            description: name of the description.
            arrays: arrays of the model.
            rounded: names of arrays that may have rounding errors; in all others, all bits must be equal.
        """
        before, now = self.digests(description), digests(arrays)
        changed = [name for name in (before | now) if before.get(name) != now.get(name)]
        stored = {name: self.array(description, name) for name in (before if changed else ())}
        return differences(stored, arrays, changed, rounded)


def write(path: Path, models: Mapping[str, Figures], largest: int = LARGEST) -> None:
    """Write the arrays of models by the names of their descriptions."""
    known = {description: digests(figures.arrays) for description, figures in models.items()}
    names = sorted({name for found in known.values() for name in found})
    document = {
        "mujoco": mujoco.__version__,
        "probe": probe(),
        "descriptions": {description: figures.source for description, figures in models.items()},
        "arrays": {name: _row([found.get(name, "none") for found in known.values()]) for name in names},
    }
    path.write_text(_lines(document), encoding="utf-8")
    sizes = [[_size(figures.arrays.get(name), largest) for figures in models.values()] for name in names]
    with zipfile.ZipFile(path.with_suffix(".npz"), "w", zipfile.ZIP_DEFLATED, compresslevel=9) as file:
        for name, array in [("sizes", np.array(sizes, np.int32)), *_flat(models, names, largest)]:
            content = io.BytesIO()
            np.save(content, array)
            file.writestr(zipfile.ZipInfo(f"{name}.npy"), content.getvalue(), zipfile.ZIP_DEFLATED)


def _size(array: Array | None, largest: int) -> int:
    """Return the number of elements of an array that is stored, else -1."""
    return -1 if array is None or array.size > largest else array.size


def _row(found: list[str]) -> tuple[str, str]:
    """Return the most frequent digest, and all digests in a text, in which the most frequent one is left out."""
    ((usual, _),) = Counter(found).most_common(1)
    return usual, ",".join("" if each == usual else each for each in found)


def _lines(document: Mapping[str, object]) -> str:
    """Return a document as JSON with one entry of its mappings a line, so that a diff names the arrays that changed."""
    parts = []
    for key, value in document.items():
        items = (
            [f"  {json.dumps(name)}: {json.dumps(one)}" for name, one in value.items()]
            if isinstance(value, dict)
            else []
        )
        parts.append(f"{json.dumps(key)}: " + ("{\n" + ",\n".join(items) + "\n}" if items else json.dumps(value)))
    return "{" + ",\n".join(parts) + "}\n"


def _flat(models: Mapping[str, Figures], names: list[str], largest: int) -> Iterator[tuple[str, Array]]:
    """Yield the elements of each array of all models, one model after the other."""
    for name in names:
        found = [figures.arrays.get(name) for figures in models.values()]
        kept = [array.ravel() for array in found if array is not None and _size(array, largest) >= 0]
        yield name, np.concatenate(kept or [np.zeros(0)])


def told(found: list[Difference], model: mujoco.MjModel, most: int = 30) -> str:
    """Return differences as text, a line for each array."""
    lines = [difference.told(model) for difference in itertools.islice(found, most)]
    return "\n".join([*lines, f"and {len(found) - most} more arrays"] if len(found) > most else lines)
