"""A session that a program forgets to close ends without a word."""

from __future__ import annotations

import subprocess
import sys

from tests.cli.harness import ROOT, environment
from tests.waiting import PATIENCE

FORGETFUL = """
import graphengine as ge

sim = ge.load("dd100_flat", rays="mujoco").session(transport="dds")
"""


def test_an_unclosed_session_prints_nothing_at_exit(domain_id: int) -> None:
    done = subprocess.run(
        [sys.executable, "-c", FORGETFUL],
        cwd=ROOT,
        env=environment({"ROS_DOMAIN_ID": str(domain_id), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}),
        capture_output=True,
        text=True,
        timeout=2 * PATIENCE,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
