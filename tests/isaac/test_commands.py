"""`graphrun import` and `graphrun export` as their users have them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.harness import Graphrun, Result
from tests.isaac.harness import ROOT, SCRIPTS

SCAN = SCRIPTS / "tutorial" / "scan.py"


def test_import_writes_a_file_for_each_graph_and_says_so(imports: Graphrun, graphrun: Graphrun, tmp_path: Path) -> None:
    done = imports(SCRIPTS / "two_robots.py")
    assert done.code == 0
    assert [path.name for path in sorted(tmp_path.iterdir())] == ["beta_01_tf.yaml", "tf.yaml"]
    assert "beta_01_tf.yaml: 3 nodes, 6 wires, at /World/beta_01/tf" in done.out
    assert "left out, because it does not belong to a graph: stage.DefinePrim('/World/alpha_00/frames')," in done.out
    assert graphrun("check", *map(str, sorted(tmp_path.iterdir()))).code == 0


def test_import_for_a_robot_writes_a_parameter_in_place_of_its_path(
    imports: Graphrun, graphrun: Graphrun, tmp_path: Path
) -> None:
    done = imports(SCRIPTS / "tutorial" / "cmd_vel.py", "--robot", "/dd100")
    assert (done.code, "10 wires, at $(robot)/Geometry/base_link/chassis_link/cmd_vel" in done.out) == (0, True)
    text = (tmp_path / "cmd_vel.yaml").read_text(encoding="utf-8")
    assert "parameters:\n  robot: {type: target, default: /dd100}\n" in text
    assert '"$(robot)"' in text
    assert text.count("/dd100") == 1
    scene = "format: 1\nscene: own\nworld: worlds/flat_grid.xml\nrobots: {other: {use: bot.yaml}}\n"
    (tmp_path / "own.yaml").write_text(scene, encoding="utf-8")
    bot = "format: 1\nrobot: bot\nextends: robots/dd100.yaml\ngraphs: {cmd_vel: {use: cmd_vel.yaml}}\n"
    (tmp_path / "bot.yaml").write_text(bot, encoding="utf-8")
    checked = graphrun("check", str(tmp_path / "own.yaml"))
    assert (checked.code, "3 graphs: 0 errors" in checked.lines[-1]) == (0, True)


@pytest.mark.parametrize(
    ("path", "complaint"),
    [
        ("dd100", "'dd100' is not a prim path; write one such as /World/robot"),
        ("/", "'/' is not a prim path"),
        ("/dd10", "--robot /dd10: no graph names this prim; the graphs are at /dd100/"),
    ],
)
def test_import_refuses_a_robot_that_no_graph_names(
    imports: Graphrun, tmp_path: Path, path: str, complaint: str
) -> None:
    done = imports(SCRIPTS / "tutorial" / "cmd_vel.py", "--robot", path)
    assert (done.code, complaint in done.err) == (2, True)
    assert list(tmp_path.iterdir()) == []


def test_import_makes_the_folder(imports: Graphrun, tmp_path: Path) -> None:
    assert imports(SCAN, "-o", str(tmp_path / "new/folder")).code == 0
    assert list((tmp_path / "new/folder").glob("*.yaml"))


def test_import_writes_over_nothing_unless_it_is_told_to(imports: Graphrun, tmp_path: Path) -> None:
    (tmp_path / "scan.yaml").write_text("mine", encoding="utf-8")
    done = imports(SCAN)
    assert (done.code, "scan.yaml: existing files are overwritten only with --force" in done.err) == (2, True)
    assert (tmp_path / "scan.yaml").read_text(encoding="utf-8") == "mine"
    assert imports(SCAN, "--force").code == 0
    line = SCAN.read_text(encoding="utf-8").split("\n").index("og.Controller.edit(") + 1
    text = (tmp_path / "scan.yaml").read_text(encoding="utf-8")
    assert text.startswith(f"# Imported from scan.py, line {line}\nformat: 1\n")


def test_import_of_a_script_with_a_type_that_is_not_here_succeeds_and_check_fails(
    imports: Graphrun, graphrun: Graphrun, tmp_path: Path
) -> None:
    done = imports(SCRIPTS / "unknown_types.py")
    assert (done.code, "warning W301: Mine: the node type" in done.err) == (0, True)
    assert graphrun("check", str(tmp_path / "custom.yaml")).code == 1


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["nowhere.py"], "no file 'nowhere.py'"),
        ([str(ROOT / "README.md")], "not an importable file; give a .py"),
        ([str(SCAN), "-o", str(SCAN)], "scan.py: this is not a folder"),
        ([str(SCAN), "--allow", "nowhere"], "no folder 'nowhere'"),
    ],
)
def test_import_refuses_what_makes_no_sense(arguments: list[str], complaint: str, graphrun: Graphrun) -> None:
    done = graphrun("import", *arguments)
    assert (done.code, complaint in done.err) == (2, True)


def test_import_of_what_builds_no_graph_fails(imports: Graphrun, tmp_path: Path) -> None:
    done = imports(SCRIPTS / "extension.py")
    assert (done.code, "has no graph" in done.err) == (1, True)
    assert list(tmp_path.iterdir()) == []


def test_import_of_a_stage_without_a_graph_shows_its_namespaces(imports: Graphrun, tmp_path: Path) -> None:
    stage = tmp_path / "robot.usda"
    stage.write_text('#usda 1.0\ndef Xform "dd100" {\n    custom string isaac:namespace = "dd100_0000"\n}\n')
    done = imports(stage)
    assert (done.code, done.out) == (0, "in a scene:\nnamespaces:\n  /dd100: dd100_0000\n")
    stage.write_text('#usda 1.0\ndef Xform "dd100" {\n}\n')
    done = imports(stage)
    assert (done.code, "has no graph" in done.err) == (1, True)


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
    imports: Graphrun, tmp_path: Path
) -> None:
    stage = tmp_path / "robot.usda"
    stage.write_text(VARIANTS, encoding="utf-8")
    done = imports(stage)
    assert (done.code, "a variant may have one: /World: ros = none, of none, ros2" in done.err) == (1, True)
    stage.write_text(VARIANTS.replace('ros = "none"', 'ros = "ros2"'), encoding="utf-8")
    assert imports(stage).code == 0


def test_import_gives_a_script_its_arguments(imports: Graphrun, tmp_path: Path) -> None:
    assert imports(SCRIPTS / "with_arguments.py").code == 1
    assert imports(SCRIPTS / "with_arguments.py", "--", "--rate", "2").code == 0
    assert "step: 2" in (tmp_path / "gate.yaml").read_text(encoding="utf-8")


EDIT = "og.Controller.edit({path!r}, {{'create_nodes': ('T', 'omni.graph.action.OnTick')}})\n"
START = "import omni.graph.core as og, omni.usd\nfrom pxr import Gf, Sdf, UsdGeom\n" + EDIT.format(path="/World/g")


@pytest.fixture
def builds(imports: Graphrun, tmp_path: Path) -> Graphrun:
    """`graphrun import` of a script that builds a graph and goes on."""

    def run(text: str) -> Result:
        done = imports(START + text)
        assert done.code == 0
        assert (tmp_path / "g.yaml").is_file()
        return done

    return run


def test_namespaces_of_a_script_are_shown_as_a_scene_has_them(builds: Graphrun) -> None:
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
    out = builds(text).out
    block = "  /World/robot: r1\n  /World/robot/arm: arm\n  /World/lidar: front\n  /World/g: of_the_graph\n"
    assert out.endswith(f"in a scene:\nnamespaces:\n{block}")
    assert "AddTranslateOp.Set()" in out


def test_what_a_script_built_before_it_failed_is_written(builds: Graphrun) -> None:
    err = builds("memoryview(og.get_frame())\n").err
    assert "warning W302: TypeError" in err
    assert "the script ends here; the graphs lack the parts that it would have built later" in err


def test_an_attribute_that_only_omniverse_knows_is_told(builds: Graphrun) -> None:
    text = (
        "import omni.syntheticdata as sd\n"
        "gate = sd.SyntheticData._get_node_path('Gate', '/Render')\n"
        "og.Controller.attribute(gate + '.inputs:step').set(5)\n"
        "og.Controller.set(og.Controller.attribute(f'{gate}.inputs:step'), 5)\n"
    )
    told = "the access to the attribute <unknown: omni.syntheticdata.SyntheticData._get_node_path()>"
    assert builds(text).err.count(told) == 2


def test_a_script_finds_numpy_and_isaac_sims_environment_and_may_keep_a_log(builds: Graphrun, tmp_path: Path) -> None:
    text = (
        "import os, numpy as np\n"
        "from pathlib import Path\n"
        "os.makedirs('logs', exist_ok=True)\n"
        "Path('logs/b.txt').write_text(os.environ['EXP_PATH'])\n"
        "with open('logs/a.txt', 'w') as log: print(np.random.uniform(0, 1), file=log)\n"
        "np.save('c.npy', np.zeros(3))\n"
        "og.Controller.set('/World/g/T.inputs:framePeriod', int(np.random.default_rng(1).integers(3, 4)))\n"
    )
    done = builds(text)
    assert (done.err, "framePeriod: 3" in (tmp_path / "g.yaml").read_text(encoding="utf-8")) == ("", True)
    assert "the folder 'logs', the file 'logs/b.txt', which the script writes," in done.out
    assert sorted(path.name for path in tmp_path.iterdir()) == ["g.yaml", "script.py"]


def test_functions_that_build_graphs_and_are_never_called_are_named(imports: Graphrun) -> None:
    done = imports(f"import omni.graph.core as og\ndef build():\n    {EDIT.format(path='/g')}")
    assert (done.code, "build(), line 2" in done.err) == (1, True)


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


def test_what_a_script_catches_is_told(builds: Graphrun) -> None:
    lost = "nodes: T; the script continues, but did not execute: connect T.outputs:tick"
    assert f"script.py:8:5: warning W302: no node 'U' in /World/more; {lost}" in builds(CAUGHT).err


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            "import os\ntry: os.environ['MY_ROBOT']\nexcept KeyError as e: print('no', e)",
            ["builds no graph", "the script printed: no 'MY_ROBOT'"],
        ),
        ("import carb\ncarb.log_error('no assets')\nraise SystemExit(3)", ["exit(3)", "the script printed: no assets"]),
        (
            "for n in range(9): print(f'{n}\\n')",
            ["the script printed: 6\n  the script printed: 7\n  the script printed: 8"],
        ),
    ],
)
def test_what_a_script_that_builds_nothing_printed_last_is_told(text: str, told: list[str], imports: Graphrun) -> None:
    done = imports(text)
    assert (done.code, [part for part in told if part not in done.err]) == (1, [])


def test_a_script_reads_a_folder_that_is_allowed(imports: Graphrun, tmp_path: Path) -> None:
    (tmp_path / "facts.txt").write_text("/World/there", encoding="utf-8")
    (tmp_path / "scripts").mkdir()
    script = tmp_path / "scripts" / "build.py"
    script.write_text(
        "import omni.graph.core as og\n"
        f"path = open({str(tmp_path / 'facts.txt')!r}).read()\n"
        "og.Controller.edit(path, {'create_nodes': ('T', 'omni.graph.action.OnTick')})\n",
        encoding="utf-8",
    )
    done = imports(script)
    assert (done.code, f"allow it with --allow {tmp_path}" in done.err) == (1, True)
    assert imports(script, "--allow", str(tmp_path)).code == 0
    assert (tmp_path / "there.yaml").is_file()


SCRIPT_OF_SCAN = ("export", "tutorial/scan", "--to", "isaac-script")


def test_export_writes_a_script_that_import_reads(imports: Graphrun, graphrun: Graphrun, tmp_path: Path) -> None:
    script = tmp_path / "scan.py"
    assert graphrun(*SCRIPT_OF_SCAN, "-o", str(script)).code == 0
    assert imports(script).code == 0
    done = graphrun(*SCRIPT_OF_SCAN)
    assert (done.code, done.out) == (0, script.read_text(encoding="utf-8"))
    assert graphrun(*SCRIPT_OF_SCAN, "-o", str(script)).code == 2
    assert graphrun(*SCRIPT_OF_SCAN, "-o", str(script), "--force").code == 0


@pytest.mark.parametrize(
    ("name", "complaint"),
    [
        ("dd100_flat", "export each graph from its own file"),
        ("robot_state", "Isaac Sim has no node type graphengine.ros2.RobotStatePublisher"),
    ],
)
def test_export_takes_one_graph_and_no_node_of_our_own(name: str, complaint: str, graphrun: Graphrun) -> None:
    done = graphrun("export", name, "--to", "isaac-script", "--strict")
    assert (done.code, complaint in done.err) == (1, True)


def test_export_takes_values_of_the_command_line(graphrun: Graphrun) -> None:
    given = ("export", "tutorial/cmd_vel", "--to", "isaac-script", "--set", "DiffController.wheelRadius=0.049")
    assert '("DiffController.inputs:wheelRadius", 0.049)' in graphrun(*given).out
