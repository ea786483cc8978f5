"""Mutants of descriptions through the importer: `python -m tests.bench.fuzz_import DESCRIPTION [--controllers YAML]`.

Each mutant of the description, or of the controllers' YAML if one is given, is imported as `graphrun import-robot` does, in a
process of its own; with `--world`, each mutant of an SDF file is read as the world of a scene. Printed are exceptions that are no
errors of graphengine, imports that take more than `SLOW` seconds, files that were opened outside of the folder of the description
and the package, programs that were started, libraries that were loaded, and processes that broke off.
"""

from __future__ import annotations

import argparse
import copy
import os
import random
import re
import resource
import signal
import sys
import sysconfig
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from graphengine.bringup.robots.import_robot import import_robot
from graphengine.cli import import_urdf, make_parser
from graphengine.descriptions.files.xml import Element, parse, write
from graphengine.descriptions.mjcf import mjcf, mjcf_trial
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import GraphError
from graphengine.format.files import Files, shipped
from graphengine.format.scene_spec import SceneSpec
from graphengine.format.spec_reader import read
from graphengine.physics.loading import load_world

SLOW = 5.0
HANG = 200
"""Seconds after which an import is given up."""
REHEARSAL = 5
"""Seconds of computing after which a MuJoCo model is refused."""
NASTY = (
    *("nan", "inf", "-1", "0", "1e308", "1e-320", "", " ", "-0.0", "99999999999999999999", "true", "[1, 2]", "{a: b}"),
    *("../../../etc/passwd", "/etc/passwd", "file:///etc/passwd", "package://x/y", "$(find x)", "${1/0}"),
    *("model://x", "model://../../etc", "1e16", "-1e16", "1.79769e+308", "world", "__model__", "a::b", "0 0 0 0 0 0"),
    *("&amp;", "\u202e", "\x00", "*a", "!!python/object:x"),
)
MJCF = (
    '<include file="/etc/passwd"/>',
    '<include file="../../../../etc/hosts"/>',
    '<asset><model name="m" file="/etc/hostname"/></asset>',
    '<asset><mesh name="o" file="/etc/passwd.obj"/></asset>',
    '<asset><texture name="o" type="2d" file="/proc/self/mem.png"/></asset>',
    '<asset><hfield name="o" file="/dev/zero.png"/></asset>',
    '<extension><plugin plugin="mujoco.pid"/></extension>',
    '<extension><plugin plugin="/tmp/evil.so"><instance name="i"/></plugin></extension>',
    '<worldbody><body><freejoint/><freejoint/><geom size="1"/></body></worldbody>',
    '<worldbody><body><joint type="ball"/><joint/><geom size="1"/></body></worldbody>',
    '<worldbody><replicate count="99999999"><body><geom size="1"/></body></replicate></worldbody>',
    '<worldbody><flexcomp name="f" type="grid" count="9 9 9" spacing=".1 .1 .1"/></worldbody>',
    '<worldbody><body mocap="true" name="mo"><geom size="1"/></body></worldbody>',
    '<size memory="999T" nuserdata="99999999" nkey="99999999"/>',
    '<compiler meshdir="/" assetdir=".." fusestatic="true" settotalmass="1"/>',
    '<option timestep="-1" solver="CG" integrator="RK4"><flag contact="disable" sleep="enable"/></option>',
    '<sensor><user dim="999999999" objtype="body" objname="base_link" datatype="real"/></sensor>',
    '<keyframe><key qpos="nan inf -inf 1e308"/></keyframe>',
    '<tendon><spatial name="t" width="1"><site site="imu"/><site site="imu"/></spatial></tendon>',
    '<custom><numeric name="n" size="999999999" data="1"/><text name="t" data="x"/></custom>',
    '<actuator><general joint="none" gear="0 0 0 0 0 0"/><muscle/><adhesion body="base_link"/></actuator>',
)
"""Elements that a stranger might put into a MuJoCo model."""


def mutated(text: str, dice: random.Random) -> str:
    """Return a text with one or two changes: mostly a value or word exchanged, else lines cut or doubled, or a character."""
    for _ in range(dice.randint(1, 2)):
        way = dice.random()
        if "<mujoco" in text and dice.random() < 0.2:
            places = [match.end() for match in re.finditer(r">\s", text)] or [0]
            place = dice.choice(places)
            text = text[:place] + dice.choice(MJCF) + text[place:]
            continue
        values = [match.span() for match in re.finditer(r'(?<=")[^"<>]*(?=")|(?<=>)[^<>]+(?=<)', text)]
        words = [match.span() for match in re.finditer(r"[\w.+-]+", text)] or [(0, len(text))]
        if way < 0.8:
            kind = values if values and way < 0.7 else words
            start, end = dice.choice(kind)
            text = (
                text[:start]
                + (dice.choice(NASTY) if dice.random() < 0.6 else text[slice(*dice.choice(kind))])
                + text[end:]
            )
        elif way < 0.95:
            lines = text.split("\n")
            first = dice.randrange(len(lines))
            last = first + dice.randint(1, 8)
            lines[first:last] = [] if dice.random() < 0.5 else 2 * lines[first:last]
            text = "\n".join(lines)
        else:
            place = dice.randrange(len(text) + 1)
            text = text[:place] + chr(dice.randrange(1, 0x250)) + text[place + 1 :]
    return text


def bent(root: Element, dice: random.Random) -> str:
    """Return a model with one to three changes after which it is still XML: numbers, words, elements that move or vanish."""
    root = copy.deepcopy(root)
    for _ in range(dice.randint(1, 3)):
        elements = list(root.walk())
        element, way = dice.choice(elements), dice.random()
        if way < 0.6 and (having := [each for each in elements if each.attributes]):
            element = dice.choice(having)
            name = dice.choice([*element.attributes])
            element.attributes[name] = _bent_value(element.attributes[name], elements, dice)
        elif way < 0.7 and element.children:
            element.children.pop(dice.randrange(len(element.children)))
        elif way < 0.85:
            dice.choice(elements).children.append(copy.deepcopy(element))
        else:
            other = dice.choice([each for each in elements if each.tag == element.tag])
            element.attributes.update(other.attributes)
            element.attributes.pop("name", None)
    return write(root)[0]


def _bent_value(text: str, elements: Sequence[Element], dice: random.Random) -> str:
    """Another value: one of its numbers changed, a value of another attribute, or a nasty one."""
    words, way = text.split(), dice.random()
    if way < 0.5 and words:
        changed = ("0", "-1", "1e9", "-1e-9", "1e300", "nan", "99999999999", "0.5", "2", "")
        words[dice.randrange(len(words))] = dice.choice(changed)
        return " ".join(words)
    if way < 0.8:
        return dice.choice([value for each in elements for value in each.attributes.values()])
    return dice.choice(NASTY).replace("\x00", "")


class Opened:
    """Files that this process opens outside of some folders."""

    def __init__(self, *folders: Path) -> None:
        python = {sysconfig.get_paths()[name] for name in ("stdlib", "purelib", "platlib")} | set(sys.path)
        known = (*map(str, folders), *filter(None, python), str(shipped()), "/proc", "/dev")
        self.inside = tuple(os.path.realpath(folder) for folder in known)
        self.outside: Counter[str] = Counter()
        self.ran: Counter[str] = Counter()
        sys.addaudithook(self._hook)

    def _hook(self, event: str, arguments: tuple[object, ...]) -> None:
        if event in ("subprocess.Popen", "os.exec", "os.system", "ctypes.dlopen"):
            self.ran[f"{event} {arguments[0]}"] += 1
        if event == "open" and isinstance(arguments[0], str | bytes):
            path = os.path.abspath(os.fsdecode(arguments[0]))
            if not path.startswith(self.inside):
                self.outside[path] += 1


def main() -> None:
    """Import the mutants and print what should not have happened."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("description", type=Path)
    parser.add_argument("--controllers", type=Path)
    parser.add_argument("--world", action="store_true")
    parser.add_argument("--mutants", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=0, help="number of the first mutant")
    given, more = parser.parse_known_args()
    origin = given.controllers or given.description
    text = origin.read_text(encoding="utf-8")
    root = parse(text.encode(), origin.name, Findings(), "S102") if "<mujoco" in text else None
    outcomes: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as scratch:
        package = next(
            (f for f in given.description.resolve().parents if (f / "package.xml").is_file()), given.description.parent
        )
        opened = Opened(Path(scratch), package)
        mutant = (Path(scratch) if given.controllers else given.description.parent) / f".mutant{origin.suffix}"
        try:
            for number in range(given.first, given.first + given.mutants):
                dice = random.Random(f"{given.seed}/{number}")
                changed = bent(root, dice) if root is not None and dice.random() < 0.6 else mutated(text, dice)
                mutant.write_text(changed, encoding="utf-8")
                outcomes[_apart(given, mutant, Path(scratch), more, number, opened)] += 1
                if number % 500 == 499:
                    print(f"after mutant {number}: {dict(outcomes)}", flush=True)
        finally:
            mutant.unlink(missing_ok=True)
    print(f"{origin.name}: {dict(outcomes)}")


def _apart(given: argparse.Namespace, mutant: Path, scratch: Path, more: list[str], number: int, opened: Opened) -> str:
    """Import one mutant in a child process; say how it ended."""
    child = os.fork()
    if child == 0:
        signal.alarm(HANG)  # which ends the process
        vars(mjcf)["reason_against"] = _rehearsed
        outcome = (_world if given.world else _outcome)(given, mutant, scratch, more, number)
        if opened.outside or opened.ran:
            print(f"mutant {number}: opened {dict(opened.outside)}, ran {dict(opened.ran)}", flush=True)
        os._exit(_OUTCOMES.index(outcome))
    _, status = os.waitpid(child, 0)
    if os.WIFEXITED(status):
        return _OUTCOMES[os.WEXITSTATUS(status)]
    print(f"mutant {number}: {signal.strsignal(os.WTERMSIG(status))}", flush=True)
    return "HUNG" if os.WTERMSIG(status) == signal.SIGALRM else "BROKE OFF"


def _rehearsed(text: str, models: Mapping[str, bytes], assets: Mapping[str, bytes]) -> str:
    """Rehearse a MuJoCo model as the confined process does, in a child that costs a thousandth of that."""
    child = os.fork()
    if child == 0:
        resource.setrlimit(resource.RLIMIT_CPU, (REHEARSAL, REHEARSAL))
        resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))
        mjcf_trial.rehearse(text, models, assets)
        os._exit(0)
    _, status = os.waitpid(child, 0)
    return f"ends with {status}" if status else ""


_OUTCOMES = ("imported", "refused", "FAILED")


def _outcome(given: argparse.Namespace, mutant: Path, scratch: Path, more: list[str], number: int) -> str:
    """Import one mutant; say how it ended."""
    files = [str(given.description), "--controllers", str(mutant)] if given.controllers else [str(mutant)]
    arguments = make_parser("import-robot").parse_args(
        ["import-robot", *files, "-o", str(scratch / "robot.yaml"), *more]
    )
    findings = Findings()

    def attempt() -> bool:
        import_urdf.check_source(arguments)
        source = import_urdf.find_origin(arguments, arguments.output, findings)
        return source is not None and import_robot(source, findings) is not None

    return _tried(attempt, number)


def _world(given: argparse.Namespace, mutant: Path, scratch: Path, more: list[str], number: int) -> str:
    """Load a scene in one mutant of a world; say how it ended."""
    scene, findings = mutant.with_suffix(".yaml"), Findings()
    scene.write_text(f"scene: s\nworld: {mutant.name}\n", encoding="utf-8")

    def attempt() -> bool:
        loaded = read(SceneSpec, scene, findings)
        return loaded is not None and load_world(loaded, Files.of(scene), findings) is not None

    try:
        return _tried(attempt, number)
    finally:
        scene.unlink()


def _tried(attempt: Callable[[], bool], number: int) -> str:
    begin = time.perf_counter()
    try:
        outcome = "imported" if attempt() else "refused"
    except GraphError:
        outcome = "refused"
    except Exception:
        print(f"mutant {number}:\n{traceback.format_exc()}", flush=True)
        outcome = "FAILED"
    if (seconds := time.perf_counter() - begin) > SLOW:
        print(f"mutant {number}: {seconds:.1f} s", flush=True)
    return outcome


if __name__ == "__main__":
    main()
