"""Ctrl-C ends a real process without a traceback at any moment, from the first import of the package to its exit."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.harness import ROOT, command, environment
from tests.waiting import PATIENCE

DRIVER = Path(__file__).with_name("interrupted")
MOMENTS = (0.0, 0.2, 0.5, 0.8, 1.0)
"""Share of all calls of the process after which a signal is sent; at every other moment, a second one follows soon."""
VERBS = {"check": ("check", "dd100/joint_states"), "topic": ("topic", "list", "--transport", "dds")}


def interrupted(verb: tuple[str, ...], **variables: str) -> subprocess.CompletedProcess[str]:
    """Run `graphrun`, to which `sitecustomize` in `DRIVER` sends signals as the environment variables say."""
    return subprocess.run(
        command(*verb),
        cwd=ROOT,
        env=environment({"PYTHONPATH": f"{DRIVER}{os.pathsep}{ROOT}", **variables}),
        capture_output=True,
        text=True,
        timeout=6 * PATIENCE,
        check=False,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )


@pytest.mark.skipif(sys.platform != "linux", reason="signals of other systems")
@pytest.mark.parametrize("verb", VERBS.values(), ids=VERBS)
def test_a_signal_at_any_moment_ends_a_process_without_a_traceback(verb: tuple[str, ...], tmp_path: Path) -> None:
    counted = tmp_path / "calls"
    assert interrupted(verb, SIGINT_CALLS=str(counted)).returncode == 0
    calls = int(counted.read_text(encoding="utf-8"))
    assert calls > 1000
    for number, share in enumerate(MOMENTS):
        first = max(1, int(share * calls) - 10)
        after = f"{first} {first + 300}" if number % 2 else f"{first}"
        ended = interrupted(verb, SIGINT_AFTER=after)
        assert ended.returncode in (0, 130), (after, ended)
        assert not any(word in ended.stderr for word in ("Traceback", "KeyboardInterrupt", "ignored")), (after, ended)
