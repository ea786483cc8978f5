"""`graphrun import` and `graphrun export` as their users have them."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphengine.cli import main
from tests.isaac.harness import ROOT, SCRIPTS

SCAN = SCRIPTS / "tutorial" / "scan.py"


def test_import_writes_a_file_for_each_graph_and_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["import", str(SCRIPTS / "two_robots.py"), "-o", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert [path.name for path in sorted(tmp_path.iterdir())] == ["beta_01_tf.yaml", "tf.yaml"]
    assert "beta_01_tf.yaml: 3 nodes, 6 wires, at /World/beta_01/tf" in out
    assert "left out is what belongs to no graph: stage.DefinePrim('/World/alpha_00/frames')," in out
    assert main(["check", *map(str, sorted(tmp_path.iterdir()))]) == 0


def test_import_makes_the_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["import", str(SCAN), "-o", str(tmp_path / "new/folder")]) == 0
    assert list((tmp_path / "new/folder").glob("*.yaml"))


def test_import_writes_over_nothing_unless_it_is_told_to(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "scan.yaml").write_text("mine", encoding="utf-8")
    assert main(["import", str(SCAN), "-o", str(tmp_path)]) == 2
    assert "scan.yaml: already exists; --force overwrites it" in capsys.readouterr().err
    assert (tmp_path / "scan.yaml").read_text(encoding="utf-8") == "mine"
    assert main(["import", str(SCAN), "-o", str(tmp_path), "--force"]) == 0
    line = SCAN.read_text(encoding="utf-8").split("\n").index("og.Controller.edit(") + 1
    text = (tmp_path / "scan.yaml").read_text(encoding="utf-8")
    assert text.startswith(f"# Imported from scan.py, line {line}\nformat: 1\n")


def test_import_of_a_script_with_a_type_that_is_not_here_succeeds_and_check_fails(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["import", str(SCRIPTS / "unknown_types.py"), "-o", str(tmp_path)]) == 0
    assert "warning W301: Mine: there is no node type" in capsys.readouterr().err
    assert main(["check", str(tmp_path / "custom.yaml")]) == 1


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["nowhere.py"], "no file 'nowhere.py'"),
        ([str(ROOT / "README.md")], "what can be imported ends in .py"),
        ([str(SCAN), "-o", str(SCAN)], "scan.py: not a folder"),
        ([str(SCAN), "--allow", "nowhere"], "no folder 'nowhere'"),
    ],
)
def test_import_refuses_what_makes_no_sense(
    arguments: list[str], complaint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["import", *arguments]) == 2
    assert complaint in capsys.readouterr().err


def test_import_of_what_builds_no_graph_fails(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["import", str(SCRIPTS / "extension.py"), "-o", str(tmp_path)]) == 1
    assert "builds no graph" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_import_of_a_stage_without_a_graph_shows_its_namespaces(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stage = tmp_path / "robot.usda"
    stage.write_text('#usda 1.0\ndef Xform "dd100" {\n    custom string isaac:namespace = "dd100_0000"\n}\n')
    assert main(["import", str(stage), "-o", str(tmp_path)]) == 0
    assert capsys.readouterr().out == "in a scene:\nnamespaces:\n  /dd100: dd100_0000\n"
    stage.write_text('#usda 1.0\ndef Xform "dd100" {\n}\n')
    assert main(["import", str(stage), "-o", str(tmp_path)]) == 1
    assert "builds no graph" in capsys.readouterr().err


VARIANTS = """#usda 1.0
def Xform "World" (
    variants = { string ros = "none" }
    prepend variantSets = "ros"
) {
    variantSet "ros" = {
        "none" { }
        "ros2" {
            def OmniGraph "graph" {
                def OmniGraphNode "Tick" {
                    token node:type = "omni.graph.action.OnTick"
                }
            }
        }
    }
}
"""


def test_import_of_a_stage_whose_graphs_are_in_other_variants_says_which_are_chosen(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stage = tmp_path / "robot.usda"
    stage.write_text(VARIANTS, encoding="utf-8")
    assert main(["import", str(stage), "-o", str(tmp_path)]) == 1
    assert "a variant may: /World: ros = none, of none, ros2" in capsys.readouterr().err
    stage.write_text(VARIANTS.replace('ros = "none"', 'ros = "ros2"'), encoding="utf-8")
    assert main(["import", str(stage), "-o", str(tmp_path)]) == 0


def test_import_gives_a_script_its_arguments(tmp_path: Path) -> None:
    script = str(SCRIPTS / "with_arguments.py")
    assert main(["import", script, "-o", str(tmp_path)]) == 1
    assert main(["import", script, "-o", str(tmp_path), "--", "--rate", "2"]) == 0
    assert "step: 2" in (tmp_path / "gate.yaml").read_text(encoding="utf-8")


EDIT = "og.Controller.edit({path!r}, {{'create_nodes': ('T', 'omni.graph.action.OnTick')}})\n"
START = "import omni.graph.core as og\nimport omni.usd\nfrom pxr import Gf, Sdf, UsdGeom\n" + EDIT.format(
    path="/World/g"
)


def graph_and_out(tmp_path: Path, text: str, capsys: pytest.CaptureFixture[str]) -> tuple[str, str, str]:
    """The graph file of a script, and what is told on both outputs."""
    (tmp_path / "build.py").write_text(START + text, encoding="utf-8")
    assert main(["import", str(tmp_path / "build.py"), "-o", str(tmp_path)]) == 0
    told = capsys.readouterr()
    return (tmp_path / "g.yaml").read_text(encoding="utf-8"), told.out, told.err


def test_namespaces_of_a_script_are_shown_as_a_scene_has_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (
        "from isaacsim.core.utils.prims import create_prim\n"
        "stage = omni.usd.get_context().get_stage()\n"
        "robot = UsdGeom.Xform.Define(stage, '/World/robot')\n"
        "robot.GetPrim().CreateAttribute('isaac:namespace', Sdf.ValueTypeNames.String).Set('r1')\n"
        "UsdGeom.Xform.Define(stage, '/World/robot/arm').AddTranslateOp().Set(Gf.Vec3d(0, 0, 1))\n"
        "prim = stage.GetPrimAtPath('/World/robot/arm')\n"
        "assert prim.IsValid()\n"
        "prim.CreateAttribute('isaac:namespace', Sdf.ValueTypeNames.String).Set('arm')\n"
        "create_prim('/World/lidar', 'Xform').CreateAttribute('isaac:namespace', 0).Set('front')\n"
        "stage.GetPrimAtPath('/World/g').CreateAttribute('isaac:namespace', 0).Set('of_the_graph')\n"
        "assert robot.GetAttribute('isaac:namespace').Get() == 'r1'\n"
    )
    out = graph_and_out(tmp_path, text, capsys)[1]
    block = (
        "namespaces:\n  /World/robot: r1\n  /World/robot/arm: arm\n  /World/lidar: front\n  /World/g: of_the_graph\n"
    )
    assert out.endswith(f"in a scene:\n{block}")
    assert "AddTranslateOp.Set()" in out


def test_what_a_script_built_before_it_failed_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _, _, err = graph_and_out(tmp_path, "memoryview(og.get_frame())\n", capsys)
    assert "warning W302: TypeError" in err
    assert "the script goes no further; what it would have built later is not in the graphs" in err


def test_an_attribute_that_only_omniverse_knows_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = (
        "import omni.syntheticdata as sd\n"
        "gate = sd.SyntheticData._get_node_path('Gate', '/Render')\n"
        "og.Controller.attribute(gate + '.inputs:step').set(5)\n"
        "og.Controller.set(og.Controller.attribute(f'{gate}.inputs:step'), 5)\n"
    )
    err = graph_and_out(tmp_path, text, capsys)[2]
    assert err.count("what is set at <unknown: omni.syntheticdata.SyntheticData._get_node_path()>") == 2


def test_a_script_finds_numpy_and_isaac_sims_environment_and_may_keep_a_log(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (
        "import os, numpy as np\n"
        "from pathlib import Path\n"
        "os.makedirs('logs', exist_ok=True)\n"
        "Path('logs/b.txt').write_text(os.environ['EXP_PATH'])\n"
        "with open('logs/a.txt', 'w') as log: print(np.random.uniform(0, 1), file=log)\n"
        "np.save('c.npy', np.zeros(3))\n"
        "og.Controller.set('/World/g/T.inputs:framePeriod', int(np.random.default_rng(1).integers(3, 4)))\n"
    )
    graph, out, err = graph_and_out(tmp_path, text, capsys)
    assert (err, "framePeriod: 3" in graph) == ("", True)
    assert "the folder 'logs', the file 'logs/b.txt', which the script writes," in out
    assert sorted(path.name for path in tmp_path.iterdir()) == ["build.py", "g.yaml"]


def test_functions_that_build_graphs_and_are_never_called_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    script = tmp_path / "library.py"
    script.write_text(f"import omni.graph.core as og\ndef build():\n    {EDIT.format(path='/g')}", encoding="utf-8")
    assert main(["import", str(script), "-o", str(tmp_path)]) == 1
    assert "build(), line 2" in capsys.readouterr().err


CAUGHT = """
import os, carb
try:
    nodes = [("T", "omni.graph.action.OnTick")]
    og.Controller.edit("/World/more", {"create_nodes": nodes, "connect": ("T.outputs:tick", "U.inputs:in")})
    domain = int(os.environ["ROS_DOMAIN_ID"])
    folder = os.environ["MY_ROBOT"]
except Exception as error:
    print("cannot build:", error)
"""


def test_what_a_script_catches_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _, _, err = graph_and_out(tmp_path, CAUGHT, capsys)
    lost = "nodes: T; the script goes on without connect T.outputs:tick"
    assert f"build.py:9:5: warning W302: no node 'U' in /World/more; {lost}" in err


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            "import os\ntry: os.environ['MY_ROBOT']\nexcept KeyError as e: print('no', e)",
            ["builds nothing", "it printed: no 'MY_ROBOT'"],
        ),
        ("import carb\ncarb.log_error('no assets')\nraise SystemExit(3)", ["exit(3)", "it printed: no assets"]),
        (
            "for n in range(9): print(f'line {n}\\n')",
            ["it printed: line 6\n  it printed: line 7\n  it printed: line 8"],
        ),
    ],
)
def test_what_a_script_that_builds_nothing_printed_last_is_told(
    text: str, told: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "build.py").write_text(text, encoding="utf-8")
    assert main(["import", str(tmp_path / "build.py"), "-o", str(tmp_path)]) == 1
    err = capsys.readouterr().err
    assert [part for part in told if part not in err] == []


def test_a_script_reads_a_folder_that_is_allowed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "facts.txt").write_text("/World/there", encoding="utf-8")
    (tmp_path / "scripts").mkdir()
    script = tmp_path / "scripts" / "build.py"
    script.write_text(
        "import omni.graph.core as og\n"
        f"path = open({str(tmp_path / 'facts.txt')!r}).read()\n"
        "og.Controller.edit(path, {'create_nodes': ('T', 'omni.graph.action.OnTick')})\n",
        encoding="utf-8",
    )
    given = ["import", str(script), "-o", str(tmp_path)]
    assert main(given) == 1
    assert f"allow it with --allow {tmp_path}" in capsys.readouterr().err
    assert main([*given, "--allow", str(tmp_path)]) == 0
    assert (tmp_path / "there.yaml").is_file()


def test_export_writes_a_script_that_import_reads(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    script = tmp_path / "scan.py"
    assert main(["export", "tutorial/scan", "--to", "isaac-script", "-o", str(script)]) == 0
    assert main(["import", str(script), "-o", str(tmp_path)]) == 0
    capsys.readouterr()
    assert main(["export", "tutorial/scan", "--to", "isaac-script"]) == 0
    assert capsys.readouterr().out == script.read_text(encoding="utf-8")
    assert main(["export", "tutorial/scan", "--to", "isaac-script", "-o", str(script)]) == 2
    assert main(["export", "tutorial/scan", "--to", "isaac-script", "-o", str(script), "--force"]) == 0


def test_export_takes_one_graph_and_no_node_of_our_own(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", "dd100_flat", "--to", "isaac-script"]) == 1
    assert "export them one by one" in capsys.readouterr().err
    assert main(["export", "robot_state", "--to", "isaac-script"]) == 1
    assert "there is no graphengine.ros2.RobotStatePublisher in Isaac Sim" in capsys.readouterr().err


def test_export_takes_values_of_the_command_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert (
        main(["export", "tutorial/cmd_vel", "--to", "isaac-script", "--set", "DiffController.wheelRadius=0.049"]) == 0
    )
    assert '("DiffController.inputs:wheelRadius", 0.049)' in capsys.readouterr().out
