"""Compiles worlds and robots in a confined process, to find out whether the main process can compile them safely.

MuJoCo's compiler is native code without limits: some models make it run endlessly or crash. Only a separate process can be
stopped. A request to that process is a line of JSON with lengths in bytes, followed by the contents of the files.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import re
import sys
from collections.abc import Mapping
from typing import IO

from graphengine.descriptions.engine import REFUSALS, compiled, mujoco
from graphengine.descriptions.files.xml import Element
from graphengine.descriptions.mjcf.mjcf_preparation import prepare
from graphengine.format.files import Files
from graphengine.sandbox.confinement import ProcessError, ask, confine
from graphengine.sandbox.seccomp import TIERS

MAX_SECONDS = 60.0
"""Maximum time to test an MJCF file, s."""
MAX_MEMORY_BYTES = 3 << 30
"""Address space of the process that tests an MJCF file, bytes."""
_MODULE = "graphengine.descriptions.mjcf.mjcf_trial"  # which is called __main__ in the process
_STEPS = 2
MAX_PLAIN_MEMORY = 60_000_000
"""Maximum estimated memory of a model that is compiled without a test in another process, bytes: e.g. 4000 elements."""
_PLAIN = re.compile(
    "mujoco|compiler|option|flag|statistic|visual|global|quality|headlight|map|scale|rgba|default|asset|texture|material|"
    "layer|worldbody|body|frame|inertial|freejoint|joint|geom|site|light|camera|custom|numeric"
)
"""Matches tags of elements without files, code, copies, meshes, soft bodies, tendons or actuators."""
_PLAIN_TEXT = re.compile("[^%]{0,1000}")
"""Matches values of attributes that are safe to compile: MuJoCo uses the name of an unknown class as a format of C's printf."""
_JOINT = 300_000
"""Bytes added for each joint, because the time for contacts and chains grows with the square of the number of joints."""
_QUOTED = re.compile(r'"([^"]*)"')
_passed: set[str] = set()
"""SHA-256 digests of the requests that the confined process completed; they are not sent again."""


def reason_against(text: str, models: Mapping[str, bytes], assets: Mapping[str, bytes]) -> str:
    """Return the reason why this process must not compile a model, e.g. `takes more than 60 s`; empty if it may.

    A model that MuJoCo refuses is safe to compile: MuJoCo reports its error again in this process.

    Args:
        text: text of the model.
        models: contents of the MuJoCo models to which the text refers, by name.
        assets: contents of other files to which the text refers, by name.
    """
    named = set(_QUOTED.findall(text))
    used = {name: data for name, data in assets.items() if name in named or models}
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


def is_plain(root: Element, memory: float) -> bool:
    """Return whether a model needs no test in another process: it is small, and all its elements compile quickly.

    Args:
        root: root element of the model; its file names are keys of the library.
        memory: estimated memory of the model, bytes (see `files.bounds`).
    """
    for element in root.walk():
        memory += _JOINT * element.tag.endswith("joint")
        attributes = element.attributes.items()
        texts = all(_PLAIN_TEXT.fullmatch(value) and not name.startswith("file") for name, value in attributes)
        large = element.tag == "numeric" and "size" in element.attributes
        if large or not (texts and _PLAIN.fullmatch(element.tag)):
            return False
    return memory <= MAX_PLAIN_MEMORY


def main() -> None:
    """Read one request from stdin, then compile the model and simulate a few steps."""
    stream = sys.stdin.buffer
    head = json.loads(stream.readline())
    text = stream.read(head["text"]).decode()
    models, assets = (_files(stream, head[key]) for key in ("models", "assets"))
    confine(Files(()), TIERS["mesh"], memory=MAX_MEMORY_BYTES)
    rehearse(text, models, assets)


def rehearse(text: str, models: Mapping[str, bytes], assets: Mapping[str, bytes]) -> None:
    """Compile a model as a scene would, and simulate a few steps.

    If MuJoCo refuses the model, nothing is reported here; the main process compiles it again and reports the error.
    """
    with contextlib.suppress(*REFUSALS):
        spec = mujoco.MjSpec.from_string(text, include=dict(models), assets=dict(assets))
        prepare(spec)
        whole = spec.copy()  # as `Scenery` compiles a copy, beside the original
        whole.assets.clear()
        whole.assets = dict(assets)
        model, _ = compiled(whole)
        data = mujoco.MjData(model)
        for _ in range(_STEPS):
            mujoco.mj_step(model, data)


def _files(stream: IO[bytes], lengths: Mapping[str, int]) -> dict[str, bytes]:
    return {name: stream.read(length) for name, length in lengths.items()}


if __name__ == "__main__":
    main()
