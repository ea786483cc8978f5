"""The argument parser of `graphrun`, whose error messages suggest corrections."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Collection, Iterable, Sequence
from typing import Any, NoReturn

FEW = 12
"""Maximum number of legal values that the error message for an illegal value lists."""
_MISSING = re.compile(r"the following arguments are required: (.*)")
_CHOICE = re.compile(r"argument (\S+): invalid choice: '(.*)' \(choose from (.*)\)", re.DOTALL)


class Parser(argparse.ArgumentParser):
    """A parser whose error messages suggest corrections of misspelt words, list legal values, and have no control characters."""

    def parse_known_args(  # type: ignore[override]  # typeshed's overloads say no more
        self, args: Sequence[str] | None = None, namespace: Any = None
    ) -> tuple[Any, list[str]]:
        """Parse arguments; exit with an error if some are unknown.

        So the parser of the verb reports unknown arguments, and can suggest similar options of the verb. In argparse, the
        top-level parser reports them, which does not know these options.
        """
        parsed, unknown = super().parse_known_args(args, namespace)
        if unknown:
            options = [word.partition("=")[0] for word in unknown if word.startswith("--")]
            self.error(f"unrecognized arguments: {' '.join(unknown)}{_hint(options, self._option_string_actions)}")
        return parsed, unknown

    def error(self, message: str) -> NoReturn:
        """Print an error in the command line with a suggestion; exit with the parser's default `wrong_usage`, or with 2."""
        from graphengine.cli import terminal
        from graphengine.cli.common import clean

        if choice := _CHOICE.fullmatch(message):
            argument, given, listed = choice.groups()
            message = f"argument {argument}: invalid choice: '{given}'"
            if not argument.startswith("-"):
                message = f"no {argument.lower()} '{given}'"
            names = re.findall(r"[\w-]+", re.sub(r" \([^()]*\)", "", listed))  # without the help of transports
            message += _hint([given], names) or _choices(names)
        elif missing := _MISSING.fullmatch(message):
            known = {action.metavar or action.dest: action.choices for action in self._actions}
            message = f"{missing[1]} {'are' if ', ' in missing[1] else 'is'} missing{_choices([*(known.get(missing[1]) or ())])}"
        text = clean(f"{self.prog}: {message}\n  see {self.prog} --help\n")
        self.exit(self.get_default("wrong_usage") or 2, terminal.wrapped(text, sys.stderr))


def _choices(names: Collection[Any]) -> str:
    """Return a line that lists the legal values; empty without legal values, or with more than `FEW`."""
    return f"\n  choose from: {', '.join(str(name) for name in names)}" if 0 < len(names) <= FEW else ""


def _hint(words: Iterable[str], legal: Iterable[str]) -> str:
    """Return a line with a suggestion for each word that is similar to a legal word; empty if no word is."""
    from graphengine.format.wording import did_you_mean

    names = list(legal)
    return "".join(f"\n  {near}" for word in words if (near := did_you_mean(word, names)))


def add_verb(verbs: Any, name: str, summary: str, **more: Any) -> Any:
    """Add and return the parser of a verb. The summary, as a sentence, is the description of the parser."""
    about = f"{summary[0].upper()}{summary[1:]}."
    return verbs.add_parser(name, help=summary.replace("%", "%%"), description=about, **more)
