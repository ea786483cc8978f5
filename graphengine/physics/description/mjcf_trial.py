"""Tries to compile a robot's MuJoCo model in a confined process, before this one does.

MuJoCo's compiler is native code without limits: some models make it run endlessly, which nothing in this process could stop, or
crash the process. A request is a line of JSON, followed by the files.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import sys
from collections.abc import Mapping
from typing import IO

from graphengine.format.files import Files
from graphengine.physics.description.mjcf_preparation import prepare
from graphengine.physics.engine import REFUSALS, compiled, mujoco
from graphengine.sandbox.confinement import ProcessError, ask, confine
from graphengine.sandbox.seccomp import TIERS

MAX_SECONDS = 60.0
MAX_MEMORY_BYTES = 4 << 30
_MODULE = "graphengine.physics.description.mjcf_trial"  # which is called __main__ in the process
_STEPS = 2

_passed: set[str] = set()
"""Fingerprints of the requests that ended normally."""


def reason_against(text: str, models: Mapping[str, bytes], assets: Mapping[str, bytes]) -> str:
    """Return why this process must not compile a model; empty if it may, also if MuJoCo refuses the model.

    Args:
        text: text of the model.
        models: MuJoCo models to which it refers, by name.
        assets: other files to which it refers, by name.
    """
    used = {name: data for name, data in assets.items() if f'"{name}"' in text or models}
    head = {"text": len(text.encode())} | {
        key: {name: len(data) for name, data in files.items()} for key, files in (("models", models), ("assets", used))
    }
    request = b"".join((json.dumps(head).encode(), b"\n", text.encode(), *models.values(), *used.values()))
    fingerprint = hashlib.sha256(request).hexdigest()
    if fingerprint not in _passed:
        try:
            ask(_MODULE, request, MAX_SECONDS)
        except ProcessError as error:
            return str(error)
        _passed.add(fingerprint)
    return ""


def main() -> None:
    """Compile and step the model of one request."""
    stream = sys.stdin.buffer
    head = json.loads(stream.readline())
    text = stream.read(head["text"]).decode()
    models, assets = (_files(stream, head[key]) for key in ("models", "assets"))
    confine(Files(()), TIERS["mesh"], memory=MAX_MEMORY_BYTES)
    rehearse(text, models, assets)


def rehearse(text: str, models: Mapping[str, bytes], assets: Mapping[str, bytes]) -> None:
    """Compile a model and step it as a scene would; what MuJoCo refuses is reported where the model is compiled again."""
    with contextlib.suppress(*REFUSALS):
        spec = mujoco.MjSpec.from_string(text, include=dict(models), assets=dict(assets))
        prepare(spec)
        model, _ = compiled(spec)
        data = mujoco.MjData(model)
        for _ in range(_STEPS):
            mujoco.mj_step(model, data)


def _files(stream: IO[bytes], lengths: Mapping[str, int]) -> dict[str, bytes]:
    return {name: stream.read(length) for name, length in lengths.items()}


if __name__ == "__main__":
    main()
