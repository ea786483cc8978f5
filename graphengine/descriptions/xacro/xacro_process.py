"""The confined process in which xacro expands a file: it reads one request from stdin and writes one response to stdout.

xacro was written for trusted files. Here `xacro_expressions` evaluates expressions, only files that the caller may read can be
read, and environment variables are empty. Each element keeps its source location through macros and includes, and errors refer
to this location.
"""

from __future__ import annotations

import contextlib
import functools
import io
import json
import math
import sys
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any
from xml.dom import minidom

import xacro
import yaml  # noqa: F401  xacro imports it when it loads a file, which is refused by then
from xacro import XacroException, substitution_args

from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.xml import MAX_ELEMENTS, Element, parse, read
from graphengine.descriptions.xacro import xacro_expressions
from graphengine.descriptions.xacro.absent_packages import MAX_NAMED, SCHEME, AbsentPackage, UnknownCall
from graphengine.descriptions.xacro.dom import UnwritableError, elements, node_of, place_of
from graphengine.descriptions.xacro.xacro import Expanded
from graphengine.format.diagnostics import Findings, Source, Span
from graphengine.format.files import Files
from graphengine.sandbox.confinement import MAX_MEMORY_BYTES, AccessDeniedError, check_readable, confine
from graphengine.sandbox.seccomp import TIERS
from graphengine.sandbox.untrusted import answer, reply


class AbsentPackageError(XacroException):  # type: ignore[misc]  # xacro has no types
    """An included file belongs to a missing package; the include is left out."""


class Expansion:
    """One run of xacro. Includes from missing packages are left out and reported.

    Args:
        path: path of the xacro file.
        arguments: values of its `xacro:arg` elements, by name.
        packages: resolve `$(find …)`, and decide which files may be read.
        found: a dict from package names to the folder that the caller found, or else to lines of a message why it found none.
            None if `packages` searches for packages in this process.
        text: content of the file; by default it is read from `path`.
        without: names of packages to treat as missing.
    """

    def __init__(
        self,
        path: Path,
        arguments: dict[str, str],
        packages: Packages,
        found: dict[str, str | list[str]] | None = None,
        text: str | None = None,
        without: Collection[str] = (),
    ) -> None:
        self.found = found
        self.wanted: str | None = None
        """Name of a package that the caller must find before the expansion can succeed; None if there is none."""
        self.path = path
        self.arguments = arguments
        self.packages = packages
        self.findings = Findings()
        self.node: minidom.Element | None = None
        """The element that xacro processed last; errors get its source location."""
        self.calls: list[minidom.Element] = []
        """The macro calls that are being processed, outermost first."""
        self.known: dict[str, str | None] = {}
        """Defaults of the arguments that the files declare or use, by name; None for an argument without a default."""
        self.text = text
        self.without = without
        self.absent: dict[str, AbsentPackage] = {}
        self.unknown_calls: list[UnknownCall] = []

    def run(self) -> Expanded:
        """Run xacro and return the response: the expanded document, or errors."""
        elements = self._elements()
        used = [str(path) for path in self.packages.files.used]
        absent = list(self.absent.values())
        return Expanded(elements, self.known, self.findings.items, self.wanted, used, absent, self.unknown_calls)

    def _elements(self) -> list[tuple[int, Element]]:
        self._take_over()
        try:
            xacro.init_stacks(str(self.path))
            document = self._parse(None, str(self.path))
            with contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()):
                xacro.process_doc(document, mappings=self.arguments, verbosity=0)
            root = document.documentElement
            if root is None or len(document.getElementsByTagName("*")) > MAX_ELEMENTS:
                raise AccessDeniedError(f"the file expands to more than {MAX_ELEMENTS} elements")
            return list(elements(root, Span(Source(str(self.path), ()), 1, 1)))
        except Exception as error:  # xacro raises what expressions raise
            self.node = error.node if isinstance(error, UnwritableError) else self.node
            if not self.findings.errors:
                self._tell(error)
            return []

    def _take_over(self) -> None:
        """Replace functions of the xacro module by restricted ones that also record the element being processed."""
        xacro.safe_eval = lambda text, names, _=None: xacro_expressions.evaluate(text, names)
        xacro.eval_extension = self._extension
        xacro.parse = self._parse
        for name in ("type", "vars"):
            xacro._global_symbols["python"].pop(name, None)
        for name in ("check_attrs", "reqd_attrs", "eval_all", "grab_property", "grab_macro"):
            setattr(xacro, name, self._followed(getattr(xacro, name)))
        xacro.process_include = self._followed(self._include(xacro.process_include))
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
        def call(node: minidom.Element, macros: Any, symbols: Any) -> Any:
            if self._left_out(node.tagName, macros, symbols):
                xacro.replace_node(node, by=None)
                return True
            self.calls.append(node)
            result = function(node, macros, symbols)
            self.calls.pop()
            return result

        return call

    def _left_out(self, tag: str, macros: Any, symbols: Any) -> bool:
        """Return whether an element calls an undefined macro after an include was left out; record such a call."""
        if not tag.startswith("xacro:") or tag == "xacro:call" or not any(p.includes for p in self.absent.values()):
            return False
        try:
            xacro.resolve_macro(tag.removeprefix("xacro:"), macros, symbols)
        except KeyError:
            if len(self.unknown_calls) < MAX_NAMED:
                self.unknown_calls.append(UnknownCall(tag.removeprefix("xacro:"), place_of(self.node)))
            return True
        return False

    def _include(self, function: Callable[..., Any]) -> Callable[..., Any]:
        def include(node: minidom.Element, *rest: Any) -> None:
            try:
                function(node, *rest)
            except AbsentPackageError:
                xacro.filestack.pop()
                xacro.replace_node(node, by=None)

        return include

    def _parse(self, _: object, filename: str) -> minidom.Document:
        path = Path(filename)
        if self.text is not None and path == self.path:
            return self._document(parse(self.text.encode(), filename, self.findings, "S103"), filename)
        self._refuse_absent(filename)
        check_readable(path, self.packages.files)
        if not path.is_file():
            xacro.filestack.pop()
            missing = FileNotFoundError()  # by which an optional include knows that there is none
            raise XacroException(f"no file {filename!r}", exc=missing)
        return self._document(read(path, self.findings, "S103"), filename)

    def _refuse_absent(self, filename: str) -> None:
        """Record an included file of a missing package and raise `AbsentPackageError`; do nothing for any other file."""
        name, _, rest = filename.rpartition(SCHEME)[2].partition("/")
        if SCHEME in filename and name in self.absent:
            if len(self.absent[name].includes) < MAX_NAMED:
                self.absent[name].includes.append(f"$(find {name})/{rest}")
            raise AbsentPackageError(f"no package {name!r}")

    def _document(self, root: Element | None, filename: str) -> minidom.Document:
        if root is None:
            raise AccessDeniedError(f"{filename!r} cannot be read")
        for element in root.walk():
            if element.tag == "xacro:arg":
                self.known.setdefault(element.get("name"), element.attributes.get("default"))
        document = minidom.Document()
        document.appendChild(node_of(root, document))
        return document

    def _extension(self, text: str) -> Any:
        """Return the value of a substitution `$(…)`; `text` includes the parentheses."""
        if text == "$(cwd)":
            return str(self.packages.folder)
        if text.startswith("$(eval "):
            return str(xacro_expressions.evaluate(text[len("$(eval ") : -1], self._names()))
        if text.startswith("$(arg "):
            self.known.setdefault(text[len("$(arg ") : -1].strip())
        context = {"arg": self.arguments, "filename": xacro.filestack[-1]}
        try:
            return substitution_args.resolve_args(text, context=context)
        except substitution_args.ArgException as error:
            remedy = f"write xacro_arguments: {{{error}: …}} in the robot file, or import with {error}:=…"
            raise XacroException(f"the argument {str(error)!r} has no value\n{remedy}") from None
        except substitution_args.SubstitutionException as error:
            raise XacroException(str(error)) from None

    def _names(self) -> dict[str, Any]:
        """Return the names that `$(eval …)` knows, with their values: constants of `math`, `true`, `false` and the arguments.

        Functions of `math` cannot be called, because a substitution ends at the first `)`.
        """
        known = {name: value for name, value in vars(math).items() if not name.startswith("_")}
        known |= {"true": True, "false": False}
        return known | {name: substitution_args.convert_value(text, "auto") for name, text in self.arguments.items()}

    def _find(self, package: str) -> str:
        if package in self.without:
            return self._absent(package, [f"package {package!r} is left out"])
        if self.found is not None and package not in self.found:
            self.wanted = package
            raise XacroException(f"the location of the package {package!r} is not known yet")
        folder = self.packages.find(package) if self.found is None else self.found[package]
        if folder is None or isinstance(folder, list):
            return self._absent(package, folder or self.packages.lacks(package))
        return str(Path(folder).absolute())

    def _absent(self, package: str, lacks: list[str]) -> str:
        if package not in self.absent and len(self.absent) < MAX_NAMED:
            self.absent[package] = AbsentPackage(package, place_of(self.node), lacks)
        return f"{SCHEME}{package}"

    def _environment(self, name: str) -> str:
        text = f"$(env {name}): environment variables are not read, so that a file has the same meaning everywhere"
        raise XacroException(f"{text}\ndeclare an <xacro:arg> and use $(arg …) instead")

    def _tell(self, error: Exception) -> None:
        causes = [error, getattr(error, "exc", None)]
        if any(isinstance(cause, RecursionError) for cause in causes):
            text = "the file expands without end"
        elif any(isinstance(cause, MemoryError) for cause in causes):
            text = f"the expansion takes more than {MAX_MEMORY_BYTES >> 20} MiB of memory"
        else:
            text = str(error) or type(error).__name__
        first, *more = (line.strip() for line in text.splitlines())
        called = [(place, "called here") for call in reversed(self.calls[-8:]) if (place := place_of(call)) is not None]
        span = place_of(self.node)
        related = [item for item in called if item[0] != span]
        self.findings.add("S103", f"xacro: {first}", span, *more, related=related)


def main() -> None:
    """Read a request from stdin, expand the file and write the response to stdout."""
    request = json.load(sys.stdin)
    files = Files(tuple(map(Path, request["roots"])), installed=tuple(map(Path, request["installed"])))
    packages = Packages(Path(request["folder"]), tuple(map(Path, request["paths"])), files)
    expansion = Expansion(
        Path(request["path"]), request["arguments"], packages, request["found"], request["text"], request["without"]
    )
    stream = reply()
    confine(files, TIERS["xacro"])
    answer(stream, expansion.run)


if __name__ == "__main__":
    main()
