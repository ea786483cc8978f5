"""`graphrun completion`: print the script for tab completion of verbs, options, scenes, node types and topics."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from graphengine.cli.options import add_value
from graphengine.format.diagnostics import CODES
from graphengine.format.files import shipped

SHELLS = ("bash", "zsh", "fish")
INSTALL = """to use it in this shell:
  eval "$(graphrun completion bash)"
  eval "$(graphrun completion zsh)"        after: autoload -Uz compinit && compinit
  graphrun completion fish | source

to install it:
  graphrun completion bash > ~/.local/share/bash-completion/completions/graphrun
  graphrun completion zsh > ~/.zfunc/_graphrun        with fpath=(~/.zfunc $fpath) before compinit in ~/.zshrc
  graphrun completion fish > ~/.config/fish/completions/graphrun.fish

The script contains the names of included scenes and of installed node types and verbs; install it again after an update.
It completes the topics of the run that `graphrun ctl` connects to."""
TOPICS = "graphrun ctl topics 2>/dev/null"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun completion` to its parser."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = INSTALL
    add_value(parser, "shell", "SHELL", "shell that runs the script: bash, zsh or fish", choices=SHELLS)


def execute(arguments: argparse.Namespace) -> int:
    """Print the script; return 0."""
    import shtab

    from graphengine.cli import VERBS, make_parser

    parser = make_parser(*VERBS, plugin="")
    _complete_values(parser)
    script = shtab.complete(parser, arguments.shell)
    # shtab's script for zsh registers itself with `eval` only, not with `source <(graphrun completion zsh)`.
    print(script.replace("[[ $zsh_eval_context[-1] == eval ]]", "[[ $zsh_eval_context[-1] == (eval|file) ]]"))
    return 0


def _complete_values(parser: argparse.ArgumentParser) -> None:
    """Set how the shell completes the value of each argument of a parser and of its verbs."""
    import shtab

    scenes, graphs = _names("scene"), _names("graph")
    by_metavar = {
        "SCENE": _files("scene", scenes),
        "SCENE|GRAPH": _files("scene_or_graph", [*scenes, *graphs]),
        "GRAPH": _files("graph", graphs),
        "TOPIC": _topics(),
        "FOLDER": shtab.DIRECTORY,
        "URDF|XACRO|SDF|MJCF|USD": shtab.FILE,
    }
    for verb, action in _actions(parser, ""):
        complete = by_metavar.get(str(action.metavar), shtab.FILE if action.type is Path else None)
        if (verb, action.dest) == ("nodes", "name"):
            complete = _words("node_types", _node_types())
        if (verb, action.dest) == ("explain", "codes"):
            complete = _words("codes", CODES)
        if complete is not None:
            action.complete = complete  # type: ignore[attr-defined]  # shtab reads this attribute
        elif action.choices is not None and not isinstance(action.choices, dict):
            action.choices = [str(choice).partition(" ")[0] for choice in action.choices]  # without their descriptions


def _actions(parser: argparse.ArgumentParser, verb: str) -> Iterator[tuple[str, argparse.Action]]:
    """Yield each argument of a parser and of its verbs, with the name of the verb, which is empty for the parser itself."""
    for action in parser._actions:
        yield verb, action
        if isinstance(action, argparse._SubParsersAction):
            for name, below in action.choices.items():
                yield from _actions(below, name)


def _names(kind: str) -> list[str]:
    """Return the names of the scenes or graphs that ship with the package, as `graphrun run` accepts them."""
    folder = shipped() / f"{kind}s"
    paths = sorted(path for path in folder.rglob("*.yaml") if re.search(rf"^{kind}:", path.read_text("utf-8"), re.M))
    return [str(path.relative_to(folder).with_suffix("")) for path in paths]


def _node_types() -> list[str]:
    """Return the registered and short names of all node types, sorted, without importing the built-in types."""
    from graphengine.compiler.registry import default_registry

    registry = default_registry()
    return sorted({*registry.owners, *registry.short_names})


def _words(name: str, words: Iterable[str]) -> dict[str, Any]:
    """Return a completion for shtab that offers the given words; `name` is part of the shell function's name."""
    all_words = " ".join(words)
    return _completion(name, f'compgen -W "{all_words}" -- "$1"', f"compadd -- {all_words}", all_words)


def _files(name: str, words: Iterable[str]) -> dict[str, Any]:
    """Return a completion for shtab that offers words, YAML files and folders; `name` is part of the shell function's name."""
    all_words = " ".join(words)
    local = (f'compgen -W "{all_words}"', "compgen -f -X '!*.yaml'", "compgen -f -X '!*.yml'", "compgen -d")
    bash = "\n  ".join(f'{one} -- "$1"' for one in local)
    zsh = f"compadd -- {all_words}\n  _files -g '*.(yaml|yml)'"
    return _completion(f"{name}_files", bash, zsh, f"{all_words} (__fish_complete_suffix .yaml)")


def _topics() -> dict[str, Any]:
    """Return a completion for shtab that offers the topics of a run."""
    # In single quotes: compgen would run commands that it finds in the names.
    bash = f"compgen -W '$({TOPICS})' -- \"$1\""
    return _completion("topics", bash, f'compadd -- ${{(f)"$({TOPICS})"}}', f"({TOPICS})")


def _completion(name: str, bash: str, zsh: str, fish: str) -> dict[str, Any]:
    """Return a completion for shtab.

    Args:
        name: part of the name of the shell function in bash and zsh.
        bash: body of the function in bash.
        zsh: body of the function in zsh.
        fish: words to complete in fish.
    """
    function = f"_graphrun_{name}"
    preamble = {shell: f"{function}() {{\n  {body}\n}}" for shell, body in (("bash", bash), ("zsh", zsh))}
    return {"bash": function, "zsh": function, "fish": fish, "preamble": preamble}
