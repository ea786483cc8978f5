"""Every link of the pages, README, CONTRIBUTING and CHANGELOG leads somewhere."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.docs.links import PICTURES, broken_links
from tests.docs.pages import DOCS, PAGES, blocks, name_of, quoted


@pytest.mark.parametrize("path", PAGES, ids=name_of)
def test_every_link_leads_to_a_file_a_heading_or_a_picture(path: Path) -> None:
    assert list(broken_links(path)) == []


def test_each_kind_of_broken_link_is_found(tmp_path: Path) -> None:
    docs = tmp_path / "docs"
    (docs / "guide").mkdir(parents=True)
    (tmp_path / "LICENSE").write_text("licence", encoding="utf-8")
    (docs / "empty.png").touch()
    (docs / "guide/page.md").write_text("# A page\n\n## Two `words`, here\n", encoding="utf-8")
    right = ["guide/page.md", "guide/page.md#two-words-here", "#start", "https://example.org"]
    wrong = {
        "[file](guide/gone.md)": "there is no such file",
        "[anchor](guide/page.md#gone)": "there is no heading with this anchor in page.md",
        "[own anchor](#gone)": "there is no heading with this anchor in index.md",
        "![picture](gone.png)": "there is no such file",
        "![empty picture](empty.png)": "this is no picture",
        '<img src="gone.svg">': "there is no such file",
        "[![picture in a link](gone.png)](guide/page.md)": "there is no such file",
        "[out of the site](../LICENSE)": "the site has no such page: name the file in backticks",
        "[a folder](guide)": "the site has no folders: link to a page",
        "[another host](http://example.org)": "only https:// leads out of the repository",
    }
    text = "# Start\n" + "".join(f"[right]({target})\n" for target in right) + "\n".join(wrong)
    page = docs / "index.md"
    page.write_text(f"{text}\n`[code](gone.md)`\n```text\n[a block](gone.md)\n```\n", encoding="utf-8")
    found = list(broken_links(page, tmp_path, docs))
    assert [line.rpartition(": ")[0].split(":")[1] for line in found] == [str(n) for n in range(6, 6 + len(wrong))]
    assert [line for line, problem in zip(found, wrong.values(), strict=True) if problem not in line] == []


def test_every_picture_is_shown_and_made_by_a_command_of_a_page() -> None:
    texts = [path.read_text(encoding="utf-8") for path in PAGES]
    made = " ".join(text for page in texts for _, text in quoted(page) if " " in text)
    made += " ".join(block.text for page in texts for block in blocks(page))
    made += " ".join(
        line for line in (DOCS / "pictures/README.md").read_text("utf-8").splitlines() if "by hand" in line
    )
    patterns = [name.replace("NAME", ".+") for name in re.findall(r"[\w.]+\.\w+", made)]
    kept = sorted(path for path in (DOCS / "pictures").iterdir() if path.suffix in PICTURES)
    assert [name_of(path) for path in kept if not any(path.name in page for page in texts)] == []
    assert [name_of(path) for path in kept if not any(re.fullmatch(one, path.name) for one in patterns)] == []
