from pathlib import Path

import pytest

from graphengine.descriptions.usd.prim_spans import PrimSpans

TEXT = '''#usda 1.0
( doc = "def Xform \\"Not\\" {" )
# def Xform "Nor" {
def Xform "World" (
    customData = { string a = "}" }
    prepend references = @def "x" {.usd@
)
{
    variantSet "v" = {
        "on" {
            over "Robot" { string s = """def Scope "No" {
}""" }
        }
    }
    def OmniGraph "G" { def OmniGraphNode "N" {} }
}
def "Last" {}
'''


def place(folder: Path, prim: str, text: str | bytes = TEXT) -> tuple[int, int, int]:
    path = folder / "stage.usda"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    span = PrimSpans(path).of(prim)
    return span.line, span.column, span.length


@pytest.mark.parametrize(
    ("prim", "expected"),
    [
        ("/World", (4, 12, 5)),
        ("/World/Robot", (11, 19, 5)),
        ("/World/G", (15, 20, 1)),
        ("/World/G/N", (15, 44, 1)),
        ("/Last", (17, 6, 4)),
        ("/World/Not", (1, 1, 1)),
        ("/World/Robot/No", (1, 1, 1)),
    ],
)
def test_a_prim_stands_where_its_name_stands(tmp_path: Path, prim: str, expected: tuple[int, int, int]) -> None:
    assert place(tmp_path, prim) == expected


@pytest.mark.parametrize("text", [b"", b"PXR-USDC\x00\xff", b'#usda 1.0\n}}}})))) def "a', b'#usda 1.0\n"""'])
def test_a_file_without_readable_text_has_no_places(tmp_path: Path, text: bytes) -> None:
    assert place(tmp_path, "/a", text) == (1, 1, 1)


@pytest.mark.parametrize(
    "text",
    [
        'def "b" {\n' * 200_000,
        'def "b" {' * 200_000,
        'def "b" {} ' * 200_000,
        "<" * 500_000,
        '\\"""\n' * 100_000,
        "def " * 100_000,
        '"""' + "{" * 500_000,
        "@" * 500_001,
    ],
)
def test_the_search_for_a_prim_in_odd_text_is_fast(tmp_path: Path, text: str) -> None:
    assert place(tmp_path, "/a", f"#usda 1.0\n{text}") == (1, 1, 1)


def test_a_file_is_found_where_it_is_named(tmp_path: Path) -> None:
    (tmp_path / "stage.usda").write_text("#usda 1.0\n( subLayers = [@../x.usd@] )")
    places = PrimSpans(tmp_path / "stage.usda")
    assert places.of_file("x.usd") is None
    span = places.of_file("../x.usd")
    assert span is not None
    assert (span.line, span.column, span.length) == (2, 17, 8)
