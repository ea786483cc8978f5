"""The commands of docs/guide/nav2_in_ten_minutes.md that need no ROS 2."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

from tests.cli.harness import ROOT, process
from tests.readme.test_readme import blocks

GUIDE = (ROOT / "docs/guide/nav2_in_ten_minutes.md").read_text(encoding="utf-8")


def test_the_files_are_those_that_the_guide_lists(tmp_path: Path) -> None:
    commands = [block for block in blocks(GUIDE, "sh") if block == "graphrun nav2 files dd100_hall -o nav\n"]
    assert len(commands) == 1
    process(*shlex.split(commands[0])[1:], cwd=tmp_path, code=0)
    listed = re.findall(
        r"`([^`]+)`", "".join(line.split("|")[1] for line in GUIDE.splitlines() if line.startswith("| `"))
    )
    assert {path.name for path in (tmp_path / "nav").iterdir()} == set(listed)
