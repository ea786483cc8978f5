"""Runs the commands of a page, as a user does who types them one after the other in one folder."""

from __future__ import annotations

import contextlib
import os
import re
import subprocess
import sys
from pathlib import Path

from graphengine.cli import main
from tests.docs.commands import simple_commands
from tests.third_party.installed import describe

_MODULES = {"graphrun": "graphengine.cli", "pytest": "pytest"}


class Shell:
    """A folder in which the lines of a page run: graphrun in this process, which is faster, other programs by sh."""

    def __init__(self, home: Path) -> None:
        self.folder = home / "page"
        programs = home / "bin"
        for place in (self.folder, programs):
            place.mkdir()
        for name in ("graphrun", "pytest", "python", "python3"):
            module = f"-m {_MODULES[name]}" if name in _MODULES else ""
            (programs / name).write_text(f'#!/bin/sh\nexec {sys.executable} {module} "$@"\n', encoding="utf-8")
            (programs / name).chmod(0o755)
        self._left_in = home / "left_in"
        self._has_package = False
        path = f"{programs}:{os.environ['PATH']}"
        self._environment = {**os.environ, "PATH": path, "ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"}

    def write(self, name: str, text: str) -> None:
        """Write a file that the page shows. A `pyproject.toml` counts as installed, with the modules beside it."""
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        if path.name == "pyproject.toml":
            describe(path.parent, self.folder)
            self._has_package = True

    def run(self, line: str) -> None:
        """Run one line to its end; it fails if a program of it does."""
        commands = list(simple_commands(line))
        in_shell = self._has_package or re.search(r"[|<>;$*~()#]|--import", line)
        if not in_shell and all(words[0] in ("cd", "graphrun") for words in commands):
            for words in commands:
                self._run_here(words, line)
            return
        done = subprocess.run(
            ["sh", "-ec", _with_ends(line) + '\npwd > "$0"', self._left_in],
            cwd=self.folder,
            env=self._environment,
            check=False,
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, f"{line}: exit {done.returncode}\n{done.stdout}\n{done.stderr}"
        self.folder = Path(self._left_in.read_text(encoding="utf-8").rstrip("\n"))

    def _run_here(self, words: list[str], line: str) -> None:
        if words[0] == "cd":
            self.folder = (self.folder / words[1]).resolve()
            return
        with contextlib.chdir(self.folder):
            code: object
            try:
                code = main(without_end(words[1:]))
            except SystemExit as end:  # --help and --version
                code = end.code
        assert not code, f"{line}: exit {code}"


def without_end(words: list[str]) -> list[str]:
    """Return the arguments of a run that would last until Ctrl-C with an end, and without a network and a page."""
    if words[:1] not in (["run"], ["demo"]):
        return words
    words = [word for word in words if word != "--view"]
    words += [] if "--for" in words else ["--for", "1s"]
    words += ["--no-view"] if words[0] == "demo" and "--no-view" not in words else []
    words += ["--rays", "mujoco"] if words[0] == "run" and "--rays" not in words else []  # numba starts slowly
    return words if "--transport" in words else [*words, "--transport", "memory"]


def _with_ends(line: str) -> str:
    """Return a line for sh in which each run of graphrun has an end."""
    ends = re.compile(r"\bgraphrun (?:run|demo)\b[^|<>;&]*")
    return ends.sub(lambda found: " ".join(["graphrun", *without_end(found[0].split()[1:])]) + " ", line)
