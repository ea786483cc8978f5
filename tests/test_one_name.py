"""Each module of the package has one name."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def test_no_module_is_loaded_under_two_names() -> None:
    program = """
import collections, os, sys
from graphengine.cli import main
try:
    main(["check", "graphs/dd100/cmd_vel.yaml"])
except SystemExit:
    pass
files = collections.defaultdict(set)
for name, module in list(sys.modules.items()):
    if getattr(module, "__file__", None):
        files[os.path.realpath(module.__file__)].add(name)
twice = [names for path, names in files.items() if path.startswith(os.getcwd()) and len(names - {"__main__"}) > 1]
assert "graphengine.nodes.ros2.subscribers" in sys.modules
assert "nodes" not in sys.modules and not twice, twice
"""
    subprocess.run([sys.executable, "-c", program], cwd=ROOT, check=True, capture_output=True, timeout=60)
