"""Check the source distribution and the wheel of a release: `python tests/release_contents.py dist [TAG]`.

Needs nothing beside Python, as it runs in an environment without graphengine.
"""

from __future__ import annotations

import sys
import tarfile
import zipfile
from email.parser import HeaderParser
from pathlib import Path

IN_SOURCES = (
    ".ci/run",
    ".github/workflows/release.yml",
    "CHANGELOG.md",
    "CITATION.cff",
    "Dockerfile",
    "LICENSE",
    "NOTICE",
    "README.md",
    "SECURITY.md",
    "docs/reference/robots.md",
    "examples/drive.py",
    "graphengine/__init__.py",
    "graphengine/nodes/index.json",
    "graphs/clock.yaml",
    "nodes/index.json",
    "ros/graphengine_ros/package.xml",
    "scenes/demo.yaml",
    "tests/all.sh",
    "tests/release.sh",
)
"""Files that stand for the parts of the repository, from each of which the source distribution must have all."""
IN_WHEEL = (
    "graphengine/_data/graphs/clock.yaml",
    "graphengine/_data/scenes/robots/dd100/dd100.urdf",
    "graphengine/drawing/page.css",
    "graphengine/messages/share/std_srvs/srv/Trigger.srv",
    "graphengine/nodes/index.json",
    "graphengine/py.typed",
    "graphengine/view/static/page.html",
)
STRAY = ("__pycache__", ".venv", ".git/", ".mypy_cache", ".hypothesis", "MUJOCO_LOG")


def version_of(metadata: str) -> str:
    """Return the version in the metadata of a distribution; an unexpected name or licence is an error."""
    headers = HeaderParser().parsestr(metadata)
    if headers["Name"] != "graphrun" or not headers["License-Expression"]:
        raise SystemExit(f"the distribution is {headers['Name']!r}, its licence {headers['License-Expression']!r}")
    return headers["Version"]


def check(folder: Path, tag: str) -> None:
    """Check both distributions in a folder; the first fault ends the program.

    Args:
        folder: the folder with exactly one source distribution and one wheel.
        tag: the tag of the release, empty if it has none yet.
    """
    (sources,) = folder.glob("*.tar.gz")
    (wheel,) = folder.glob("*.whl")
    with tarfile.open(sources) as archive:
        root = sources.name.removesuffix(".tar.gz")
        names = [name.removeprefix(f"{root}/") for name in archive.getnames()]
        member = archive.extractfile(f"{root}/PKG-INFO")
        assert member is not None
        version = version_of(member.read().decode())
    with zipfile.ZipFile(wheel) as archive:
        installed = archive.namelist()
        info = f"graphrun-{version}.dist-info"
        licences = [name for name in installed if name.startswith(f"{info}/licenses/")]
        found = version_of(archive.read(f"{info}/METADATA").decode())
        instructions = archive.read("graphengine/format/distribution.py").decode()
    faults = [
        *(f"{sources.name} lacks {name}" for name in IN_SOURCES if name not in names),
        *(f"{wheel.name} lacks {name}" for name in IN_WHEEL if name not in installed),
        *(f"stray file {name}" for name in [*names, *installed] if any(part in name for part in STRAY)),
        *(f"{wheel.name} installs {name}" for name in installed if not name.startswith(("graphengine/", info))),
    ]
    if found != version or (tag and tag != f"v{version}"):
        faults.append(f"versions differ: tag {tag or 'none'}, {sources.name}, {wheel.name}")
    if tag and "\nON_PYPI = True\n" not in instructions:
        faults.append(
            "graphengine/format/distribution.py says that graphrun is not on PyPI; a release needs ON_PYPI = True"
        )
    if not {"LICENSE", "NOTICE"} <= {Path(name).name for name in licences} or len(licences) < 3:
        faults.append(f"{wheel.name} lacks licences")
    if faults:
        raise SystemExit("\n".join(faults))
    print(f"{sources.name}: {len(names)} files; {wheel.name}: {len(installed)} files, {len(licences)} of them licences")


if __name__ == "__main__":
    check(Path(sys.argv[1]), (sys.argv[2:] or [""])[0])
