"""The page of the command line: each verb with its arguments, options and defaults, from the parsers."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from graphengine.cli import OLD_NAMES, VERBS, make_parser
from graphengine.cli.node_reference import code, prose, table
from graphengine.experiments import pytest_command

TEST = "test"
"""The verb that graphengine adds by an entry point, as other packages can."""

_INTRODUCTION = """# Commands

`graphrun VERB --help` prints the same texts. As a scene or graph, give a file, or the name of a scene or graph that
graphengine includes, such as `dd100_warehouse` or `dd100/cmd_vel`.
"""
_CODES = (
    ("0", "success; also if Ctrl-C, `SIGTERM` or a closed terminal ended a run"),
    ("1", "errors in files or in the run"),
    ("2", "a wrong command line"),
    ("3", "out of memory"),
    ("130", "Ctrl-C before a run began, or before a verb had its result"),
    (
        "of `test`",
        "those of pytest: 0, 1 some failed, 2 interrupted, 3 internal error, 4 wrong command line, 5 no test found",
    ),
)


def pages() -> Iterator[tuple[str, str]]:
    """Yield path and text of the page."""
    verbs = {**VERBS, TEST: pytest_command.HELP}
    rows = [(f"[{code(name)}](#{name})", prose(about)) for name, about in verbs.items()]
    former = [f"{code(new)} is also called {code(old)}, its former name." for old, new in OLD_NAMES.items()]
    lines = [_INTRODUCTION, *table(("verb", "what it does"), rows), "", *former]
    lines += ["", "## Exit codes", "", *table(("code", "meaning"), _CODES)]
    for name in verbs:
        parser = _subparsers(make_parser(name, plugin=name if name == TEST else None))[name]
        lines += ["", f"## {name}", "", *_of_parser(parser)]
        for subverb, inner in _subparsers(parser).items():
            lines += ["", f"### {name} {subverb}", "", *_of_parser(inner)]
    yield "verbs.md", "\n".join([*lines, ""])


def _subparsers(parser: argparse.ArgumentParser) -> dict[str, argparse.ArgumentParser]:
    """Return the parsers of the verbs below a parser, each under its first name."""
    found: dict[str, argparse.ArgumentParser] = {}
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, inner in action.choices.items():
                if inner not in found.values():
                    found[name] = inner
    return found


def _of_parser(parser: argparse.ArgumentParser) -> Iterator[str]:
    yield prose(parser.description or "")
    shown = [action for action in parser._actions if action.help != argparse.SUPPRESS and action.dest != "help"]
    usage = [part for action in shown if not action.option_strings and (part := _written(action))]
    usage += ["[options]"] if any(action.option_strings for action in shown) else []
    yield from ("", "```text", " ".join([parser.prog, *usage]), "```")
    rows = [
        (code(_written(action)), _text(parser, action))
        for action in shown
        if not isinstance(action, argparse._SubParsersAction)
    ]
    if rows:
        yield from ("", *table(("argument", ""), rows))
    if parser.epilog:
        is_laid_out = parser.formatter_class is argparse.RawDescriptionHelpFormatter
        yield from ("", *(("```text", parser.epilog, "```") if is_laid_out else (prose(parser.epilog),)))


def _written(action: argparse.Action) -> str:
    """Return an argument as it is typed, such as `--for TIME` or `[TOPIC]`."""
    if isinstance(action, argparse._SubParsersAction):
        return "VERB"
    value = action.metavar or ("|".join(map(str, action.choices)) if action.choices else action.dest.upper())
    value = " ".join(value) if isinstance(value, tuple) else value
    if action.nargs == 0:
        return ", ".join(action.option_strings)
    value = {"?": f"[{value}]", "*": f"[{value} …]", "+": f"{value} …", "...": f"{value} …"}.get(
        str(action.nargs), value
    )
    return f"{', '.join(action.option_strings)} {value}".strip()


def _text(parser: argparse.ArgumentParser, action: argparse.Action) -> str:
    text = parser._get_formatter()._expand_help(action) if action.help else ""
    return prose(text) + ("; required" if action.required and action.option_strings else "")
