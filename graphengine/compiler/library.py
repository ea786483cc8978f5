"""A cache of graph files: each file is read once, and its parameters are replaced once for each set of values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from graphengine.compiler.budget import Budget
from graphengine.compiler.filled_document import FilledDocument, Use
from graphengine.compiler.substitution import fill
from graphengine.format import document as documents
from graphengine.format.diagnostics import Findings
from graphengine.format.document import Document
from graphengine.format.files import Files, NotFoundError
from graphengine.format.spec import GraphSpec
from graphengine.format.spec_reader import Loaded


@dataclass(slots=True)
class GraphLibrary:
    """A cache of graph files by path. Specs are immutable, so all uses of a file with equal parameter values share one spec."""

    files: Files
    _found: dict[tuple[str, Path], tuple[Path, Path] | NotFoundError] = field(default_factory=dict)
    _documents: dict[Path, Document | None] = field(default_factory=dict)
    _filled: dict[object, Loaded[GraphSpec] | None] = field(default_factory=dict)

    def find(self, reference: str, folder: Path) -> tuple[Path, Path]:
        """Find the file that another file in `folder` refers to as `reference`.

        Returns:
            The path of the file for messages, and its path with symbolic links resolved.

        Raises:
            NotFoundError: the file does not exist, or lies outside the folders that may be read.
        """
        key = (reference, folder)
        if key not in self._found:
            try:
                path = self.files.find(reference, folder)
                self._found[key] = (path, path.resolve())
            except NotFoundError as error:
                self._found[key] = error
        found = self._found[key]
        if isinstance(found, NotFoundError):
            raise found
        return found

    def read(self, path: Path, findings: Findings) -> Document | None:
        """Return the document of a file; None if the file has an error, which only the first call adds to `findings`."""
        if path not in self._documents:
            self._documents[path] = documents.load(path, findings, given=self.files.text(path))
        return self._documents[path]

    def load(
        self, path: Path, bindings: Mapping[str, Any], findings: Findings, use: Use | None, budget: Budget
    ) -> Loaded[GraphSpec] | None:
        """Return a graph file with its parameters replaced by the values in `bindings`; None after an error.

        Args:
            path: path of the file.
            bindings: values of the parameters, by name.
            findings: receives the errors.
            use: place where another file uses the graph; None for a file that the user gave.
            budget: size limits of the graph that uses the file.

        Raises:
            OverBudgetError: the graph that uses the file exceeds its size limits.
        """
        document = self.read(path, findings)
        if document is None:
            return None
        budget.take_values(document.size)
        key = (path, _hashable(bindings))
        if key not in self._filled:
            before = len(findings.items)
            filled = fill(document, bindings, findings, use, budget)
            if len(findings.items) == before:  # otherwise each use reports the errors
                self._filled[key] = filled
            return filled
        known = self._filled[key]
        return Loaded(known.spec, FilledDocument(document, bindings.keys(), use)) if known is not None else None


def _hashable(value: Any) -> object:
    """Return a hashable key for a parameter value; values that differ in content or type have different keys."""
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, Mapping):
        return tuple((key, _hashable(item)) for key, item in value.items())
    if isinstance(value, list | tuple):
        return type(value), tuple(map(_hashable, value))
    return type(value), value
