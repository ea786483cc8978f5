"""A drive through the warehouse; as a program it prints the fingerprint of every byte that was sent."""

from __future__ import annotations

import sys
from pathlib import Path

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from tests.jobs.harness import Job, Recorder

COMMANDS = {6: (0.5, 0.0), 12: (0.6, 0.3), 40: (0.2, -0.8), 41: (0.3, 0.8), 100: (0.0, 0.0), 110: (-0.4, 0.1)}
"""Velocities by the number of the tick before which they arrive."""

SECONDS = 3


def drive(scene: str | Path = "dd100_warehouse", seed: int = 0) -> Recorder:
    with Job(scene, seed=seed) as job:
        for tick in range(1, round(SECONDS * job.rate) + 1):
            if tick in COMMANDS:
                job.say("/dd100_0000/cmd_vel", *COMMANDS[tick])
            job.session.step()
        return job.recorder


def stream_of(scene: str | Path, seed: int) -> list[tuple[str, str, bytes]]:
    """Topic, type and bytes of each message of a drive."""
    return drive(scene, seed).stream


if __name__ == "__main__":
    sys.stdout.write(f"{drive().digest}\n")
