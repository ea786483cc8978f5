"""Reads the commands of pages as a shell does, and gives those of graphrun to its own parser."""

from __future__ import annotations

import argparse
import functools
import itertools
import re
import shlex
from collections.abc import Iterator

import pytest

from graphengine.cli import OLD_NAMES, VERBS, make_parser
from graphengine.cli.parser import Parser

_OPERATORS = {"&&", "||", ";", "|", "&", ">", ">>", "<", "2>", "2>&1", ";;"}
_ASSIGNMENT = re.compile(r"[A-Za-z_]\w*=.*")
_PLACEHOLDER = re.compile(r"[\[<]?[A-Z][A-Z_0-9/:|.=…\[\]]*>?(…|\.\.\.)?")


class RefusedError(Exception):
    """The parser's message."""


def lines_of(script: str) -> Iterator[str]:
    """Yield the commands of a block; a backslash at the end of a line continues a command."""
    for line in re.sub(r"\\\n\s*", "", script).splitlines():
        if line.strip() and not line.lstrip().startswith("#"):
            yield line.strip()


def simple_commands(line: str) -> Iterator[list[str]]:
    """Yield the words of each program of a line, without operators, comments and variables before it."""
    words = shlex.shlex(line, posix=True, punctuation_chars="&|;<>")
    words.whitespace_split = True
    words.commenters = "#"
    command: list[str] = []
    for word in [*words, ";"]:
        if word in _OPERATORS:
            if command:
                yield command
            command = []
        elif command or not _ASSIGNMENT.fullmatch(word):
            command.append(word)


def graphrun_commands(text: str) -> Iterator[list[str]]:
    """Yield the arguments of each call of graphrun in a text."""
    for line in lines_of(text):
        for program, *words in simple_commands(line):
            if program.rpartition("/")[2] == "graphrun":
                yield words


def refusal(words: list[str], *, whole: bool) -> str:
    """Return what the parser says of a command of graphrun; an empty text if it takes the command.

    Args:
        words: arguments of graphrun.
        whole: whether the command can be typed as it stands. Else it may lack arguments,
            and words such as SCENE stand for others.
    """
    if not whole:
        words = list(itertools.takewhile(lambda word: word not in ("…", "..."), words))
    verb = next((word for word in words if not word.startswith("-")), "")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Parser, "error", _raise)
        try:
            _parser(OLD_NAMES.get(verb, verb)).parse_args([OLD_NAMES.get(word, word) for word in words])
        except SystemExit:  # --help and --version
            return ""
        except RefusedError as error:
            named = re.findall(r"'([^']*)'", str(error))
            if not whole and (re.search("required|expected", str(error)) or any(map(_PLACEHOLDER.fullmatch, named))):
                return ""
            return f"graphrun {' '.join(words)}: {error}"
    return ""


def _raise(self: Parser, message: str) -> None:
    raise RefusedError(message)


@functools.cache
def _parser(verb: str) -> argparse.ArgumentParser:
    return make_parser(verb, plugin=None if verb in VERBS else verb)  # the verb `test` is one by entry point
