"""The confined process in which xacro expands a file: one request on stdin, one response on stdout.

xacro was written for trusted files. Here `xacro_expressions` evaluates expressions, only files that the caller may read are
read, the environment is empty, and the process is confined. Each element keeps its position through macros and includes, so
that errors refer to the line that contains them.
"""

from __future__ import annotations

import contextlib
import functools
import io
import json
import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.dom import minidom

import xacro
import yaml  # noqa: F401  xacro imports it when it loads a file, which is refused by then
from xacro import XacroException, substitution_args

from graphengine.format.diagnostics import Findings, Source, Span
from graphengine.format.files import Files
from graphengine.physics.description import xacro_expressions
from graphengine.physics.description.dom import UnwritableError, elements, node_of, place_of
from graphengine.physics.description.xacro import Expanded
from graphengine.physics.files.packages import Packages
from graphengine.physics.files.xml import MAX_ELEMENTS, Element, read
from graphengine.sandbox.confinement import MAX_MEMORY_BYTES, AccessDeniedError, check_readable, confine
from graphengine.sandbox.seccomp import TIERS
from graphengine.sandbox.untrusted import answer, reply


class Expansion:
    """One run of xacro.

    Args:
        path: xacro file.
        arguments: values of its `xacro:arg` elements.
        packages: packages for `$(find …)`, which also decide which files may be read.
        found: folders of the packages that the caller looked up, or why they are missing; None: look them up here.
    """

    def __init__(
        self,
        path: Path,
        arguments: dict[str, str],
        packages: Packages,
        found: dict[str, str | list[str]] | None = None,
    ) -> None:
        self.found = found
        self.wanted: str | None = None
        """A package that the caller has to look for, before the file can be expanded."""
        self.path = path
        self.arguments = arguments
        self.packages = packages
        self.findings = Findings()
        self.node: minidom.Element | None = None
        """The last element that xacro turned to."""
        self.calls: list[minidom.Element] = []
        """The macro calls that it is in."""
        self.known: set[str] = set()
        """Names of the arguments that the files take."""

    def run(self) -> Expanded:
        """Return the expanded document, or its errors."""
        elements = self._elements()
        used = [str(path) for path in self.packages.files.used]
        return Expanded(elements, self.known, self.findings.items, self.wanted, used)

    def _elements(self) -> list[tuple[int, Element]]:
        self._take_over()
        try:
            xacro.init_stacks(str(self.path))
            document = self._parse(None, str(self.path))
            with contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()):
                xacro.process_doc(document, mappings=self.arguments, verbosity=0)
            root = document.documentElement
            if root is None or len(document.getElementsByTagName("*")) > MAX_ELEMENTS:
                raise AccessDeniedError(f"it expands to more than {MAX_ELEMENTS} elements")
            return list(elements(root, Span(Source(str(self.path), ()), 1, 1)))
        except Exception as error:  # xacro raises what expressions raise
            self.node = error.node if isinstance(error, UnwritableError) else self.node
            if not self.findings.errors:
                self._tell(error)
            return []

    def _take_over(self) -> None:
        """Replace functions of the xacro module, which it looks up by name at each call."""
        xacro.safe_eval = lambda text, names, _=None: xacro_expressions.evaluate(text, names)
        xacro.eval_extension = self._extension
        xacro.parse = self._parse
        for name in ("type", "vars"):
            xacro._global_symbols["python"].pop(name, None)
        for name in ("check_attrs", "reqd_attrs", "eval_all", "process_include", "grab_property", "grab_macro"):
            setattr(xacro, name, self._followed(getattr(xacro, name)))
        xacro.handle_macro_call = self._followed(self._call(xacro.handle_macro_call))
        substitution_args._eval_find = self._find
        substitution_args._eval_env = self._environment

    def _followed(self, function: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(function)
        def follow(node: minidom.Element, *rest: Any) -> Any:
            self.node = node
            return function(node, *rest)

        return follow

    def _call(self, function: Callable[..., Any]) -> Callable[..., Any]:
        def call(node: minidom.Element, *rest: Any) -> Any:
            self.calls.append(node)
            result = function(node, *rest)
            self.calls.pop()
            return result

        return call

    def _parse(self, _: object, filename: str) -> minidom.Document:
        path = Path(filename)
        check_readable(path, self.packages.files)
        if not path.is_file():
            xacro.filestack.pop()
            missing = FileNotFoundError()  # by which an optional include knows that there is none
            raise XacroException(f"no file {filename!r}", exc=missing)
        root = read(path, self.findings, "S103")
        if root is None:
            raise AccessDeniedError(f"{filename!r} cannot be read")
        self.known |= {element.get("name") for element in root.walk() if element.tag == "xacro:arg"}
        document = minidom.Document()
        document.appendChild(node_of(root, document))
        return document

    def _extension(self, text: str) -> Any:
        """Return the value of a `$(…)`."""
        if text == "$(cwd)":
            return str(self.packages.folder)
        if text.startswith("$(eval "):
            return str(xacro_expressions.evaluate(text[len("$(eval ") : -1], self._names()))
        if text.startswith("$(arg "):
            self.known.add(text[len("$(arg ") : -1].strip())
        context = {"arg": self.arguments, "filename": xacro.filestack[-1]}
        try:
            return substitution_args.resolve_args(text, context=context)
        except substitution_args.ArgException as error:
            remedy = f"give it: xacro_arguments: {{{error}: …}} in the robot file, {error}:=… to import-urdf"
            raise XacroException(f"the argument {str(error)!r} has no value\n{remedy}") from None
        except substitution_args.SubstitutionException as error:
            raise XacroException(str(error)) from None

    def _names(self) -> dict[str, Any]:
        """Return the names known in `$(eval …)`: `math` and the arguments. It ends at the first `)`, so it calls no functions."""
        known = {name: value for name, value in vars(math).items() if not name.startswith("_")}
        known |= {"true": True, "false": False}
        return known | {name: substitution_args.convert_value(text, "auto") for name, text in self.arguments.items()}

    def _find(self, package: str) -> str:
        if self.found is not None and package not in self.found:
            self.wanted = package
            raise XacroException(f"the package {package!r} lies where this process may not look")
        folder = self.packages.find(package) if self.found is None else self.found[package]
        if isinstance(folder, list):
            raise XacroException("\n".join(folder))
        if folder is None:
            raise XacroException("\n".join(self.packages.lacks(package)))
        return str(Path(folder).absolute())

    def _environment(self, name: str) -> str:
        text = f"$(env {name}): the environment is not read, so that a file means the same everywhere"
        raise XacroException(f"{text}\nmake it an argument")

    def _tell(self, error: Exception) -> None:
        causes = [error, getattr(error, "exc", None)]
        if any(isinstance(cause, RecursionError) for cause in causes):
            text = "it expands without end"
        elif any(isinstance(cause, MemoryError) for cause in causes):
            text = f"it takes more than {MAX_MEMORY_BYTES >> 20} MiB"
        else:
            text = str(error) or type(error).__name__
        first, *more = (line.strip() for line in text.splitlines())
        called = [(place, "called here") for call in reversed(self.calls[-8:]) if (place := place_of(call)) is not None]
        span = place_of(self.node)
        related = [item for item in called if item[0] != span]
        self.findings.add("S103", f"xacro: {first}", span, *more, related=related)


def main() -> None:
    """Answer one request."""
    request = json.load(sys.stdin)
    files = Files(tuple(map(Path, request["roots"])), installed=tuple(map(Path, request["installed"])))
    packages = Packages(Path(request["folder"]), tuple(map(Path, request["paths"])), files)
    expansion = Expansion(Path(request["path"]), request["arguments"], packages, request["found"])
    stream = reply()
    confine(files, TIERS["xacro"])
    answer(stream, expansion.run)


if __name__ == "__main__":
    main()
