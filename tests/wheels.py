"""Wheels that are written by hand, so that tests need neither a network nor a build backend, and environments for them."""

from __future__ import annotations

import base64
import hashlib
import os
import subprocess
import sys
import zipfile
from collections.abc import Mapping
from pathlib import Path

from graphengine.format.distribution import NAME, PACKAGE
from graphengine.format.version import __version__

ROOT = Path(__file__).resolve().parents[1]
SCRIPT = f"[console_scripts]\n{NAME} = {PACKAGE}.cli:main\n"


def make_wheel(folder: Path, name: str, version: str, files: Mapping[str, bytes], entry_points: str = "") -> Path:
    """Write a wheel with the given files into a folder; return its path."""
    about = f"{name}-{version}.dist-info"
    contents = {
        **files,
        f"{about}/METADATA": f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n".encode(),
        f"{about}/WHEEL": b"Wheel-Version: 1.0\nGenerator: tests\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
        f"{about}/entry_points.txt": entry_points.encode(),
    }
    record = [f"{path},sha256={_digest(data)},{len(data)}\n" for path, data in contents.items()]
    contents[f"{about}/RECORD"] = "".join([*record, f"{about}/RECORD,,\n"]).encode()
    path = folder / f"{name}-{version}-py3-none-any.whl"
    with zipfile.ZipFile(path, "w") as wheel:
        for member, data in contents.items():
            wheel.writestr(member, data)
    return path


def own_wheel(folder: Path) -> Path:
    """Write a wheel of this checkout, without node types, message types, graphs and scenes."""
    texts = [
        path for path in sorted((ROOT / PACKAGE).rglob("*.*")) if path.suffix in (".py", ".txt") and path.is_file()
    ]
    files = {path.relative_to(ROOT).as_posix(): path.read_bytes() for path in texts}
    return make_wheel(folder, NAME, __version__, files, SCRIPT)


class Environment:
    """A virtual environment with the packages of this one, except numba, which takes long to compile, and this package."""

    def __init__(self, folder: Path) -> None:
        subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder], check=True)
        self.python = folder / "bin/python"
        self.site = next(folder.glob("lib/python*/site-packages"))
        for name in sys.path:
            for path in Path(name).iterdir() if name.endswith("-packages") else ():
                left_out = path.name.lower().partition("-")[0] in (NAME, PACKAGE, "numba")
                if not left_out and path.suffix != ".pth" and not (self.site / path.name).exists():
                    (self.site / path.name).symlink_to(path)

    def pip(self, *words: str | Path) -> None:
        """Run pip in this environment, without a network."""
        pip = [self.python, "-m", "pip", "--disable-pip-version-check", "--no-input"]
        offline = {
            **os.environ,
            "PIP_NO_INDEX": "1",
            "PIP_NO_DEPS": "1",
            "PIP_NO_COMPILE": "1",
            "PIP_NO_WARN_CONFLICTS": "1",
        }
        subprocess.run([*map(str, pip), *map(str, words)], check=True, capture_output=True, env=offline, timeout=100)

    def graphrun(self, *words: str, changes: Mapping[str, str] | None = None) -> subprocess.CompletedProcess[str]:
        """Run `graphrun` of this environment; `changes` are environment variables."""
        others = ("PYTHON", "ROS_", "RMW_", "AMENT_", "CYCLONE", "NUMBA_")
        clean = {name: value for name, value in os.environ.items() if not name.startswith(others)}
        return subprocess.run(
            [self.python, "-m", "graphengine.cli", *words],
            capture_output=True,
            text=True,
            check=False,
            cwd=self.site,
            env={**clean, **(changes or {})},
            timeout=100,
        )


def _digest(data: bytes) -> str:
    return base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
