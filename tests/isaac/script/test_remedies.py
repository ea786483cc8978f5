"""What a user may say of a script that fails or builds nothing: `--assume`, `--call`, and where it is run."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphengine.cli import main
from graphengine.format.diagnostics import Findings
from graphengine.isaac.script.script_reader import ScriptOptions, read_script

IMPORTS = "import os, sys\nfrom pathlib import Path\nimport omni.graph.core as og\n"
EDIT = "og.Controller.edit({path}, {{'create_nodes': ('Tick', 'omni.graph.action.OnTick')}})\n"
BUILD = f"def build(path):\n    {EDIT.format(path='path')}"


def paths(script: Path, text: str, *assume: str, calls: tuple[str, ...] = ()) -> tuple[list[str], Findings]:
    """The paths of the graphs of a script, and its findings."""
    script.write_text(IMPORTS + text, encoding="utf-8")
    findings = Findings()
    graphs = read_script(script, findings, options=ScriptOptions(assume=assume, calls=calls))
    return [graph.path for graph in graphs], findings


@pytest.mark.parametrize(
    ("condition", "offered", "given"),
    [
        ("Path('/isaac/jazzy/lib').is_dir()", "/isaac/jazzy/lib", "/isaac/jazzy/lib/"),
        ("os.path.isdir('/isaac/ros2.bridge')", "/isaac/ros2.bridge", "/isaac/ros2.bridge"),
        ("Path('/isaac/a folder').is_dir()", "'/isaac/a folder'", "/isaac/a folder"),
        ("os.path.isfile('/isaac/robot.usd') and '-' in sys.argv", "/isaac/robot.usd", ""),
        ("os.path.isfile('/isaac/policy.pt')", "/isaac/policy.pt", "/isaac/policy.pt"),
    ],
)
def test_a_file_or_folder_of_another_machine_is_offered_and_assumed(
    condition: str, offered: str, given: str, tmp_path: Path
) -> None:
    first, second = (EDIT.format(path=path) for path in ("'/F'", "'/G'"))
    text = f"{first}if {condition}:\n    {second}"
    built, findings = paths(tmp_path / "asks.py", text)
    assert (built, findings.warnings[0].help) == (["/F"], (f"--assume {offered} assumes that it exists",))
    if given:
        assert paths(tmp_path / "asks.py", text, given)[0] == ["/F", "/G"]


@pytest.mark.parametrize("condition", ["os.path.isfile('/isaac/robot.usd')", "Path('/isaac/lib').is_dir()"])
def test_a_script_that_is_nothing_without_a_file_of_another_machine_finds_it(condition: str, tmp_path: Path) -> None:
    text = f"if not {condition}: raise OSError\n" + EDIT.format(path="'/G'")
    built, findings = paths(tmp_path / "asks.py", text)
    assert (built, findings.errors + findings.warnings) == (["/G"], [])
    assert [finding.code for finding in findings.items] == ["N302"]


def test_enabling_an_extension_works_where_the_stage_holds_all(tmp_path: Path) -> None:
    text = "from isaacsim.core.utils import app\nif not app.enable_extension('ros2'): raise OSError\n"
    built, findings = paths(tmp_path / "enables.py", text + EDIT.format(path="'/G'"))
    assert (built, findings.errors + findings.warnings) == (["/G"], [])


@pytest.mark.parametrize("before", ["build('/A')", "raise OSError\nbuild('/A')", "sys.exit()\nbuild('/A')"])
def test_calls_alone_decide_what_is_built(before: str, tmp_path: Path) -> None:
    built, findings = paths(tmp_path / "calls.py", f"{BUILD}{before}\n", calls=("build('/A')", "build('/B')"))
    assert (built, findings.errors) == (["/A", "/B"], [])
    assert "graphs that the script builds without --call are left out: /A" in [
        finding.message for finding in findings.items
    ]


def test_a_builder_inside_a_function_that_failed_is_listed(tmp_path: Path) -> None:
    text = f"{BUILD}def main():\n    open('/etc/passwd')\n    build('/A')\nmain()\n"
    (error,) = paths(tmp_path / "fails.py", text)[1].errors
    assert error.help[-2:] == ("  build(path), line 4", "  main(), line 6")


def test_a_script_goes_on_behind_what_fails_in_a_function_but_for_what_it_tries_itself(tmp_path: Path) -> None:
    text = f"{BUILD}def main():\n    {{}}['robot']\n    build('/A')\n"
    text += "    try:\n        {}['tried']\n        build('/B')\n    except KeyError: build('/C')\nmain()\n"
    built, findings = paths(tmp_path / "fails.py", text)
    assert (built, findings.errors) == (["/A", "/C"], [])
    said = [(warning.span.line, warning.message) for warning in findings.warnings if warning.span]
    assert said[0] == (7, "KeyError: 'robot'; the script continues after the failed statement")
    assert said[1] == (11, "build() is never reached, because of the error at line 10: KeyError: 'tried'")


def test_what_a_condition_asked_before_is_offered_too(tmp_path: Path) -> None:
    text = f"{BUILD}import omni.usd\nstage = omni.usd.get_context().get_stage()\nbuild('/A')\n"
    text += "def there():\n    return stage.GetPrimAtPath('/World/a').IsValid()\n"
    text += "found = there() and\\\n    stage.GetPrimAtPath('/World/b').IsValid()\nif found: build('/B')\n"
    (warning,) = paths(tmp_path / "asks.py", text)[1].warnings
    assert warning.help == ("--assume /World/a assumes that the prim exists",)
    (warning,) = paths(tmp_path / "asks.py", text, "/World/a")[1].warnings
    assert warning.help == ("--assume /World/b assumes that the prim exists",)


def test_only_what_a_condition_asks_is_offered_and_a_node_of_ros_is_no_graph(tmp_path: Path) -> None:
    text = "import rclpy, omni.usd\nomni.usd.get_context().get_stage().GetPrimAtPath('/World/robot').IsValid()\n"
    text += f"{BUILD}build('/A')\nif len(sys.argv) > 1:\n    rclpy.create_node('bridge')\n    build('/B')\n"
    (warning,) = paths(tmp_path / "ros.py", text)[1].warnings
    assert (warning.message.split("()")[0], warning.help) == ("build", ())


def test_a_file_beside_the_script_names_the_folder_to_run_in(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    here, folder = tmp_path / "here", tmp_path / "script"
    here.mkdir()
    folder.mkdir()
    (folder / "facts.txt").write_text("facts", encoding="utf-8")
    text = f"{IMPORTS}{BUILD}build('/A')\ntry:\n    open('facts.txt')\n    build('/B')\nexcept Exception: pass\n"
    (folder / "reads.py").write_text(text, encoding="utf-8")
    monkeypatch.chdir(here)
    assert main(["import", str(folder / "reads.py")]) == 0
    err = capsys.readouterr().err
    assert f"  relative paths begin at the folder where graphrun runs: cd {folder}\n" in err
    assert "\N{REPLACEMENT CHARACTER}" not in err
