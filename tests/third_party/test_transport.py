"""A transport by somebody else, in a package of one file: found by its entry point, used, and held to the contract."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.third_party.installed import lay_out

ACME = Path(__file__).parent / "acme_transport"
ROOT = Path(__file__).parents[2]
CONTRACT = [*sorted((ROOT / "tests" / "ros").glob("test_contract_*.py")), ROOT / "tests" / "ros" / "test_services.py"]


@pytest.fixture
def site(tmp_path: Path) -> Path:
    """A folder of installed packages with Acme's transport in it."""
    folder = tmp_path / "site"
    folder.mkdir()
    lay_out(ACME, "acme_transport.py", folder)
    return folder


def python(site: Path, *arguments: str, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run Python where the folder is among the installed packages."""
    environment = {**os.environ, **variables, "PYTHONPATH": os.pathsep.join((str(site), str(ROOT)))}
    return subprocess.run(
        [sys.executable, *arguments], capture_output=True, text=True, check=False, env=environment, cwd=ROOT
    )


def graphrun(site: Path, *words: str) -> subprocess.CompletedProcess[str]:
    return python(site, "-m", "graphengine.cli", *words)


def test_it_keeps_the_contract_of_transports(site: Path) -> None:
    words = ["-q", "-p", "no:cacheprovider", "-k", "acme", *map(str, CONTRACT)]
    done = python(site, "-m", "pytest", *words, GRAPHENGINE_TRANSPORT="acme")
    assert done.returncode == 0, done.stdout
    assert "skipped" not in done.stdout


def test_a_graph_runs_on_it(site: Path) -> None:
    done = graphrun(site, "run", "clock", "--transport", "acme", "--for", "0.1", "--rate", "max")
    assert done.returncode == 0, done.stderr
    assert "acme, domain" in done.stderr + done.stdout


def test_a_verb_that_looks_for_others_refuses_a_transport_that_reaches_none(site: Path) -> None:
    done = graphrun(site, "topic", "list", "--transport", "acme")
    assert done.returncode == 2
    assert "invalid choice: 'acme'" in done.stderr


def test_help_has_its_line(site: Path) -> None:
    done = graphrun(site, "run", "--help")
    assert "acme (other nodes of the same process)" in " ".join(done.stdout.split())


def test_one_that_cannot_be_imported_says_why_and_what_to_do(site: Path) -> None:
    (site / "acme_transport.py").unlink()
    (site / "acme_transport.py").write_text("import zenoh_of_acme\n")
    done = graphrun(site, "run", "clock", "--transport", "acme")
    assert done.returncode == 1
    assert "transport 'acme' of acme-transport cannot be imported: ModuleNotFoundError: No module named" in done.stderr
    assert "install the dependencies of acme-transport, or uninstall it" in done.stderr
    assert graphrun(site, "run", "clock", "--transport", "memory", "--for", "0.1").returncode == 0


def test_one_whose_check_fails_is_passed_over_by_auto_and_says_why_where_it_is_named(site: Path) -> None:
    lines = [
        "from graphengine.ros.transport import TransportKind",
        "def missing(): raise RuntimeError('the driver is broken')",
        "TRANSPORT = TransportKind('acme', 'nobody', print, auto=0, missing=missing)",
    ]
    (site / "acme_transport.py").unlink()
    (site / "acme_transport.py").write_text("\n".join(lines))
    environment = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"}
    done = python(
        site, "-m", "graphengine.cli", "run", "clock", "--for", "0.1", "--rate", "max", "--verbose", **environment
    )
    assert done.returncode == 0, done.stderr
    assert "acme cannot be used (RuntimeError: the driver is broken)" in done.stderr + done.stdout
    done = graphrun(site, "run", "clock", "--transport", "acme")
    assert done.returncode == 1
    assert done.stderr.splitlines()[0] == "error: acme cannot be used: RuntimeError: the driver is broken"


def test_two_packages_with_one_name_are_refused(site: Path) -> None:
    about = site / "other-1.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: other\nVersion: 1\n")
    (about / "entry_points.txt").write_text("[graphengine.transports]\nacme = other:TRANSPORT\n")
    done = graphrun(site, "run", "clock", "--transport", "acme")
    assert done.returncode == 1
    assert "several packages provide a transport 'acme': acme_transport:TRANSPORT, other:TRANSPORT" in done.stderr
