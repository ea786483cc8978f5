"""A verb by somebody else, in a package of one file: found by its entry point, listed, completed, suggested and executed."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from graphengine.cli import VERBS
from tests.third_party.installed import lay_out

ACME = Path(__file__).parent / "acme_turns"
ROOT = Path(__file__).parents[2]
NEEDED = "a verb needs the text HELP and the functions add_arguments(parser) and execute(arguments)"
NEEDED += "; update acme-turns, or uninstall it"
CONFLICT = "ArgumentError: argument -h: conflicting option string: -h"


@pytest.fixture
def site(tmp_path: Path) -> Path:
    """A folder of installed packages with Acme's verb in it."""
    folder = tmp_path / "site"
    folder.mkdir()
    lay_out(ACME, "acme_turns.py", folder)
    return folder


def graphrun(site: Path, *words: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join((str(site), str(ROOT))), "COLUMNS": "200"}
    command = [sys.executable, "-m", "graphengine.cli", *words]
    return subprocess.run(command, capture_output=True, text=True, check=False, env=environment, cwd=ROOT)


def register(site: Path, package: str, name: str, value: str) -> None:
    """Install another package that adds a verb."""
    about = site / f"{package}-1.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1\n")
    (about / "entry_points.txt").write_text(f"[graphengine.verbs]\n{name} = {value}\n")


def write(site: Path, text: str) -> None:
    """Replace the module of Acme's verb."""
    (site / "acme_turns.py").unlink()
    (site / "acme_turns.py").write_text(text)


def test_it_is_executed_with_its_arguments_and_exit_codes(site: Path) -> None:
    done = graphrun(site, "turns", "6.283185307", "--radius", "0.25")  # 2 pi m, 2 pi 0.25 m a turn
    assert (done.returncode, done.stdout, done.stderr) == (0, "4.000\n", "")
    assert graphrun(site, "turns", "--", "-1").returncode == 3
    done = graphrun(site, "turns", "1", "--radius", "0")
    assert (done.returncode, done.stderr) == (2, "graphrun turns: --radius 0: write a number above 0\n")
    done = graphrun(site, "turns", "1", "--radios", "0")
    assert done.returncode == 2
    assert "did you mean '--radius'?" in done.stderr


def test_its_help_names_its_package_and_keeps_percent_signs(site: Path) -> None:
    done = graphrun(site, "turns", "--help")
    assert done.returncode == 0
    assert "Print how often a wheel turns over a distance, within 0.1 % (from acme-turns)." in done.stdout
    assert "--radius RADIUS" in done.stdout


def test_help_lists_plugin_verbs_only_with_all_and_mentions_that_in_one_line(site: Path) -> None:
    brief, full = graphrun(site, "--help"), graphrun(site, "--help", "--all")
    assert "turns" not in brief.stdout
    assert len(re.findall("installed packages", brief.stdout)) == 1
    assert re.search(r"^    turns +print how often .* within 0\.1 % \(from acme-turns\)$", full.stdout, re.MULTILINE)
    assert full.stdout == graphrun(site, "--all", "--help").stdout
    assert "graphrun uses the built-in verb.\n" in full.stdout


def test_without_such_packages_help_lists_the_verb_that_graphengine_adds_in_the_same_way(tmp_path: Path) -> None:
    told = graphrun(tmp_path, "--help", "--all").stdout
    assert re.search(r"^    test  +run scenarios .* with pytest \(from graphrun\)$", told, re.MULTILINE)


def test_built_in_and_former_verbs_take_precedence_and_help_lists_the_unused_ones(site: Path) -> None:
    register(site, "acme_schema", "schema", "acme_nowhere")
    register(site, "acme_import", "import-urdf", "acme_nowhere")
    assert graphrun(site, "schema", "scene").returncode == 0
    assert "usage: graphrun import-robot" in graphrun(site, "import-urdf", "--help").stdout
    told = graphrun(site, "--help", "--all").stdout
    assert "not used: import-urdf of acme_import, schema of acme_schema." in told


def test_a_misspelt_verb_gets_the_verb_of_an_installed_package_as_a_suggestion(site: Path) -> None:
    done = graphrun(site, "turn", "1")
    assert done.returncode == 2
    assert done.stderr.splitlines()[:2] == ["graphrun: no verb 'turn'", "  did you mean 'turns'?"]


def test_plugin_verbs_are_completed_even_if_one_of_them_is_broken(site: Path) -> None:
    register(site, "acme_broken", "broken", "acme_nowhere")
    done = graphrun(site, "completion", "bash")
    assert (done.returncode, done.stderr) == (0, "")
    verbs = re.search(r"_shtab_graphrun_subparsers=\(([^)]*)\)", done.stdout)
    assert verbs is not None
    assert re.findall(r"[\w-]+", verbs[1]) == [*VERBS, "broken", "test", "turns"]
    assert "_shtab_graphrun_turns_option_strings=(-h --help --radius)" in done.stdout.replace("'", "")


@pytest.mark.parametrize(
    ("module", "lines"),
    [
        (
            "import acme_core",
            [
                "error: verb 'turns' of acme-turns cannot be imported: ModuleNotFoundError: No module named 'acme_core'",
                "install the dependencies of acme-turns, or uninstall it",
            ],
        ),
        (
            "raise SystemExit('no licence')",
            [
                "error: verb 'turns' of acme-turns cannot be imported: SystemExit: no licence",
                "install the dependencies of acme-turns, or uninstall it",
            ],
        ),
        (
            "HELP = 'turn'\ndef run(arguments): return 0",
            [
                "error: verb 'turns' of acme-turns: acme_turns has no add_arguments and no execute",
                NEEDED,
            ],
        ),
        (
            "HELP = 'turn'\ndef execute(arguments): return 0\ndef add_arguments(parser): parser.add_argument('-h')",
            [
                f"error: verb 'turns' of acme-turns: add_arguments failed: {CONFLICT}",
                "update acme-turns, or uninstall it",
            ],
        ),
    ],
    ids=["import", "exit", "lacking", "arguments"],
)
def test_an_unusable_verb_is_refused_with_the_reason_and_a_remedy(site: Path, module: str, lines: list[str]) -> None:
    write(site, module)
    done = graphrun(site, "turns", "1")
    assert (done.returncode, done.stdout, done.stderr.splitlines()) == (1, "", lines)
    listed = graphrun(site, "--help", "--all")
    assert (listed.returncode, listed.stderr) == (0, "")
    assert re.search(r"^    turns +(verb 'turns' of acme-turns|turn \(from acme-turns\))", listed.stdout, re.MULTILINE)


def test_an_exception_in_a_third_party_verb_prints_its_traceback(site: Path) -> None:
    write(site, "HELP = 'turn'\ndef add_arguments(parser): ...\ndef execute(arguments): return 1 / 0")
    done = graphrun(site, "turns")
    assert done.returncode == 1
    assert "acme_turns.py" in done.stderr
    assert done.stderr.endswith("ZeroDivisionError: division by zero\n")


def test_two_packages_with_one_verb_are_refused(site: Path) -> None:
    register(site, "other", "turns", "other_turns")
    done = graphrun(site, "turns", "1")
    assert done.returncode == 1
    assert done.stderr.splitlines() == [
        "error: several packages provide a verb 'turns': acme_turns, other_turns",
        "uninstall all but one",
    ]


def test_built_in_verbs_look_for_no_packages(site: Path) -> None:
    script = (
        "import sys; from graphengine.cli import main\n"
        "try: main(['--help'])\nexcept SystemExit: print('importlib.metadata' in sys.modules)"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join((str(site), str(ROOT)))}
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, env=environment)
    assert done.stdout.splitlines()[-1] == "False"
