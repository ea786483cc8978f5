import re
from pathlib import Path

import pytest

pytest.importorskip("pxr")

from pxr import Sdf

from graphengine.descriptions.usd import layers as stage_layers
from graphengine.descriptions.usd.layers import UnreadableError, open_stage
from graphengine.format.files import Files
from graphengine.isaac.stage.stage_contents import StageContents
from graphengine.isaac.stage.stage_process import StageReading
from tests.isaac.stage.harness import node, read

SECRET = f'#usda 1.0\ndef OmniGraph "Secret" {{ {node("C")} }}\n'.replace(" }", "\n}")


@pytest.fixture
def home(tmp_path: Path) -> Path:
    """A folder of a stranger's files; beside it lies what they must not read."""
    (tmp_path / "secret.usda").write_text(SECRET)
    folder = tmp_path / "stranger"
    folder.mkdir()
    return folder


def left_out(folder: Path, text: str, **others: str) -> list[tuple[str, str]]:
    stage = read(folder, text, **others)
    assert not stage.graphs
    assert not any("secret" in used for used in stage.contents.used)
    assert Sdf.Layer.Find(str(folder.parent / "secret.usda")) is None
    return [(what, re.sub("; needed by [^;]*", "", why)) for what, why in stage.contents.left_out]


REFUSED = "it lies outside the folder of the file you gave; allow it with --allow {}"


VARIANT = """#usda 1.0
def "a" (
    variants = { string v = "on" }
    prepend variantSets = "v"
) {
    variantSet "v" = {
        "on" (references = @../secret.usda@</Secret>) { }
    }
}
"""


@pytest.mark.parametrize(
    "text",
    [
        "#usda 1.0\n( subLayers = [@../secret.usda@] )",
        "#usda 1.0\n( subLayers = [@{absolute}@] )",
        '#usda 1.0\ndef "a" (references = @../secret.usda@</Secret>) {}',
        '#usda 1.0\ndef "a" (payload = @{absolute}@</Secret>) {}',
        '#usda 1.0\ndef "a" (references = @deeper/../../secret.usda@</Secret>) {}',
        '#usda 1.0\ndef "a" (references = @link.usda@</Secret>) {}',
        VARIANT,
    ],
)
def test_nothing_outside_the_folder_is_read(home: Path, text: str) -> None:
    (home / "link.usda").symlink_to(home.parent / "secret.usda")
    text = text.replace("{absolute}", str(home.parent / "secret.usda"))
    assert [why for _, why in left_out(home, text)] == [REFUSED.format(home.parent)]


def test_a_layer_within_the_folder_leads_outside_no_more_than_the_first(home: Path) -> None:
    inner = '#usda 1.0\ndef "a" (references = @../secret.usda@</Secret>) { }'
    ((what, why),) = left_out(home, "#usda 1.0\n( subLayers = [@inner.usda@] )", inner=inner)
    assert (what, why) == ("../secret.usda", f"{REFUSED.format(home.parent)}; inner.usda refers to it")


def test_an_allowed_folder_is_read(home: Path) -> None:
    path = home / "stage.usda"
    path.write_text("#usda 1.0\n( subLayers = [@../secret.usda@] )")
    contents = StageReading(Files.of(path, [home.parent])).run(path)
    assert list(contents.prims) == ["/Secret", "/Secret/C"]


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("omniverse://server/robot.usd", "it is on a server, which is never asked"),
        ("https://example.org/robot.usd", "it is on a server, which is never asked"),
        ("gone.usd", "the file does not exist"),
        ("./gone.usd", "the file does not exist"),
        ("folder.usd", "the file does not exist"),
        ("notes.txt", "it is not a .usd, .usda, .usdc or .usdz file"),
        ("pack.usdz[a.usda]", "the file does not exist"),
        ('`"${WHERE}.usda"`', "its name contains an expression or arguments"),
        ("inner.usda:SDF_FORMAT_ARGS:a=b", "its name contains an expression or arguments"),
    ],
)
def test_what_cannot_be_read_is_cut_off_and_told(home: Path, name: str, why: str) -> None:
    (home / "folder.usd").mkdir()
    (home / "notes.txt").write_text("#usda 1.0\n")
    text = f'#usda 1.0\n(\n expressionVariables = {{ string WHERE = "../secret" }}\n)\ndef "a" (references = @{name}@) {{}}'
    assert left_out(home, text, inner=SECRET) == [(name, why)]


def test_a_layer_that_usd_refuses_is_cut_off(home: Path) -> None:
    ((what, why),) = left_out(home, '#usda 1.0\ndef "a" (references = @broken.usda@) {}', broken="#usda 1.0\ndef {")
    assert what == "broken.usda"
    assert "broken.usda:2:" in why


CLIPS = """#usda 1.0
def "a" (
    clips = {
        dictionary default = {
            asset[] assetPaths = [@../secret.usda@]
            string primPath = "/Secret"
            double2[] active = [(0, 0)]
            double2[] times = [(0, 0)]
        }
    }
) {
    double x
}
"""


def test_value_clips_are_not_opened(home: Path) -> None:
    assert not left_out(home, CLIPS)


def test_layers_that_lead_to_each_other_are_read_once(home: Path) -> None:
    graph = f'#usda 1.0\n( subLayers = [@b.usda@] )\ndef OmniGraph "G" {{ {node("C")} }}'
    stage = read(home, "#usda 1.0\n( subLayers = [@a.usda@, @b.usda@, @./a.usda@] )", a=graph, b="#usda 1.0\n")
    assert [Path(used).name for used in stage.contents.used] == ["stage.usda", "a.usda", "b.usda"]
    assert [graph.path for graph in stage.graphs] == ["/G"]


def test_a_link_leads_to_what_lies_beside_the_file_itself(home: Path, tmp_path: Path) -> None:
    folder = tmp_path / "größe [1]"
    folder.mkdir()
    (folder / "stage.usda").write_text("#usda 1.0\n(\n    subLayers = [@./graph.usda@]\n)\n")
    (folder / "graph.usda").write_text(SECRET)
    link = home / "link.usda"
    link.symlink_to(folder / "stage.usda")
    contents = StageReading(Files.of(link)).run(link)
    assert list(contents.prims) == ["/Secret", "/Secret/C"]


def test_references_within_a_layer_stay(home: Path) -> None:
    text = f'#usda 1.0\ndef "A" {{ def OmniGraph "G" {{ {node("C")} }} }}\ndef "B" (prepend references = </A>) {{}}'
    assert [graph.path for graph in read(home, text).graphs] == ["/A/G", "/B/G"]


def test_size_and_number_of_layers_are_bounded(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = "#usda 1.0\n( subLayers = [@a.usda@, @b.usda@] )"
    monkeypatch.setattr(stage_layers, "MAX_LAYERS", 2)
    assert left_out(home, text, a="#usda 1.0\n", b="#usda 1.0\n") == [("b.usda", "the stage has more than 2 files")]
    monkeypatch.setattr(stage_layers, "MAX_BYTES", 100)
    too_large = "the files of the stage are together larger than 0 MB"
    assert left_out(home, text, a="#usda 1.0\n" + "#" * 100) == [("a.usda", too_large), ("b.usda", too_large)]


@pytest.mark.parametrize("name", ["stage.txt", "gone.usda"])
def test_a_stage_that_cannot_be_opened_says_why(home: Path, name: str) -> None:
    (home / "stage.txt").write_text("#usda 1.0\n")
    with pytest.raises(UnreadableError):
        open_stage(home / name, Files.of(home / "stage.txt"))
    assert isinstance(StageReading(Files.of(home / "stage.txt")).run(home / name), StageContents)


def test_text_that_is_not_utf_8_is_refused(home: Path) -> None:
    (home / "stage.usda").write_bytes(b'#usda 1.0\ndef Xf\xc8rm "a" {\n}\n')
    assert (
        StageReading(Files.of(home / "stage.usda")).run(home / "stage.usda").failure == "it has text that is not UTF-8"
    )
