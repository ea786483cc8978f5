"""`graphrun ctl`: ask a running session for something, from another terminal."""

from __future__ import annotations

import argparse
import json
import math
import os
import re
import sys
from typing import TYPE_CHECKING, Any

from graphengine.cli import Parser
from graphengine.cli.common import clean, counted, parse_set, table
from graphengine.cli.quantities import angle, duration, number, rate, vector, whole
from graphengine.control.client import Client, find
from graphengine.control.runs import Entry
from graphengine.format.errors import ControlError
from graphengine.format.wording import listing

if TYPE_CHECKING:
    from collections.abc import Callable

EXAMPLES = """examples:
  graphrun run dd100_warehouse --paused        in one terminal; in another:
  graphrun ctl step 60                         one second, tick by tick, then it waits again
  graphrun ctl play
  graphrun ctl rate 0.5
  graphrun ctl push dd100 --force 0,80,0 --for 0.5s
  graphrun ctl move dd100 0 4 --yaw 90deg
  graphrun ctl spawn second robots/dd100.yaml --at 0,6,0.03 --namespace second
  graphrun ctl set DiffController.maxLinearSpeed=0.5
  graphrun ctl reset --scope state
  graphrun ctl checkpoint before; graphrun ctl push dd100 --impulse 0,9,0; graphrun ctl restore before

A run answers to the user who started it, on the same machine, whatever its transport. What is asked for is done between two
ticks. Lengths are in m, times in s of simulation, forces in N; angles are in rad, or in degrees when written as 90deg."""

SCOPES = ("time", "state", "spawned", "all")


_NEGATIVE = re.compile(r"-[.0-9][-+.,0-9e]*(deg|rad|s|ms|min)?(,.*)?")


class _Parser(Parser):
    """A parser for which `-1,2,0` and `-90deg` are no options, as `-1` is none for any."""

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Take what begins with a number for a value, by the space that no option has."""
        return super().parse_known_args(
            [f" {word}" if _NEGATIVE.fullmatch(word) else word for word in args or ()], namespace
        )


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the verb."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = EXAMPLES
    common = _Parser(add_help=False)
    common.add_argument("--run", metavar="NAME|PID", default="", help="which one, where several run")
    common.add_argument("--json", action="store_true", help="print how the session is then as JSON")
    verbs = parser.add_subparsers(dest="command", metavar="COMMAND", required=True, parser_class=_Parser)

    def add(name: str, summary: str, *fields: str, make: Callable[..., dict[str, Any]] | None = None) -> Any:
        description = f"{summary[0].upper()}{summary[1:]}."
        sub = verbs.add_parser(name, help=summary, description=description, parents=[common])
        sub.set_defaults(arguments=make or (lambda given: {field: getattr(given, field) for field in fields}))
        return sub

    add("state", "whether it plays, its time and rate, its robots and what else can be moved")
    add("play", "let time pass")
    add("pause", "hold the time where it is")
    add("stop", "back to time 0, everything as at the start, until it plays again")
    add("quit", "end the run, as Ctrl-C does")
    step = add("step", "run single ticks of a session that is paused", "ticks")
    step.add_argument("ticks", metavar="TICKS", nargs="?", type=whole, default=1, help="how many (default 1)")
    reset = add("reset", "begin anew, and go on", "scope")
    scope = (
        "time: clock, graphs and sensors; state: where things are; spawned: robots that came are removed (default all)"
    )
    reset.add_argument("--scope", choices=SCOPES, action="append", help=scope)
    rate = add("rate", "how fast simulation time passes", "factor")
    rate.add_argument("factor", metavar="FACTOR", type=_rate, help="realtime, max, or a factor of real time")
    _add_robots(add)
    _add_forces(add)
    put = add("set", "give an input of a node another value", make=_set)
    values = "[ROBOT/][GRAPH/]NODE.PORT=VALUE of an input that no wire feeds; globs allowed"
    put.add_argument("input", metavar="NODE.PORT=VALUE", help=values)
    impulse = add("impulse", "let an OnImpulseEvent node fire", "node")
    impulse.add_argument("node", metavar="NODE", help="its prim path, or as much of the end as no other has")
    for name, summary in (("press", "hold keys down"), ("release", "let go of keys")):
        keys = add(name, summary, "keys")
        keys.add_argument("keys", metavar="KEY", nargs="+", help="as OnKeyboardInput calls them: W, Space, LeftShift")
    checkpoint = add("checkpoint", "keep a copy of the whole state, to go back to it", "name")
    checkpoint.add_argument("name", metavar="NAME", help="for `restore`")
    restore = add("restore", "go back to a checkpoint", "name")
    restore.add_argument("name", metavar="NAME", help="of the checkpoint")


def _add_robots(add: Callable[..., Any]) -> None:
    spawn = add("spawn", "put a robot into the scene", make=_spawn)
    spawn.add_argument("name", metavar="NAME", help="of the robot in the scene, which no other has")
    file = "robot file: of this folder, else as the scene would write it; the run has to be allowed to read it"
    spawn.add_argument("use", metavar="ROBOT", help=file)
    spawn.add_argument("--at", metavar="X,Y[,Z]", type=vector(2, 3), default=(0.0, 0.0), help="of its base link, m")
    _add_rotation(spawn)
    spawn.add_argument("--namespace", metavar="NAMESPACE", help="of its topics, in place of the robot file's")
    spawn.add_argument("--prim", metavar="PATH", help="path of its prim, as in /World/robot (default: /NAME)")
    state = "publish what robot_state_publisher would"
    spawn.add_argument("--robot-state", action="store_true", help=state)
    delete = add("delete", "take a robot out of the scene", "name")
    delete.add_argument("name", metavar="NAME", help="of the robot")
    move = add("move", "put a robot, or an object of the world, somewhere else", make=_move)
    move.add_argument("entity", metavar="NAME", help="of the robot or the object")
    for axis in "xyz":
        of_it = "m, of a robot's base link or of the object" + (
            "; the height stays if not given" if axis == "z" else ""
        )
        move.add_argument(axis, metavar=axis.upper(), nargs="?", type=number, help=of_it)
    _add_rotation(move)
    move.add_argument("--linear", metavar="X,Y,Z", type=vector(3), help="velocity, m/s")
    move.add_argument("--angular", metavar="X,Y,Z", type=vector(3), help="velocity about the world's axes, rad/s")


def _add_forces(add: Callable[..., Any]) -> None:
    push = add("push", "let a force act on a robot or an object", "entity", "force", "impulse", "duration", "at")
    push.add_argument("entity", metavar="NAME", help="of the robot or the object")
    one = push.add_mutually_exclusive_group(required=True)
    one.add_argument("--force", metavar="X,Y,Z", type=vector(3), help="N, in the world")
    one.add_argument("--impulse", metavar="X,Y,Z", type=vector(3), help="N s, in the world")
    how_long = "how long, in simulation time: 0.5s, 200ms (default for an impulse: one tick)"
    push.add_argument("--for", dest="duration", metavar="TIME", type=duration, help=how_long)
    push.add_argument(
        "--at", metavar="X,Y,Z", type=vector(3), help="where in the world (default: at its centre of mass)"
    )


def _add_rotation(parser: argparse.ArgumentParser) -> None:
    one = parser.add_mutually_exclusive_group()
    one.add_argument("--yaw", metavar="ANGLE", type=angle, help="about the vertical")
    one.add_argument("--rpy", metavar="R,P,Y", type=vector(3, item=angle), help="about fixed axes, as in URDF")
    one.add_argument("--quaternion", metavar="X,Y,Z,W", type=vector(4), help="scalar last")


def _rotation(given: argparse.Namespace) -> dict[str, Any] | None:
    """An orientation as scene files write it."""
    if given.quaternion is not None:
        return {"quaternion_xyzw": given.quaternion}
    turned = given.rpy if given.rpy is not None else (0.0, 0.0, given.yaw) if given.yaw is not None else None
    return {"rpy_deg": [math.degrees(value) for value in turned]} if turned is not None else None


def _rate(text: str) -> float | str:
    """What `rate` reads, as JSON can say it."""
    factor = rate(text)
    return "max" if math.isinf(factor) else factor


def _spawn(given: argparse.Namespace) -> dict[str, Any]:
    """The file is named from the folder of whoever asks, where it is there; the run looks elsewhere for others."""
    use: dict[str, Any] = {
        "use": os.path.abspath(given.use) if os.path.isfile(given.use) else given.use,
        "at": given.prim,
        "position": (*given.at, 0.0)[:3],
        "orientation": _rotation(given),
        "namespace": given.namespace,
        "robot_state": given.robot_state,
    }
    return {"name": given.name, "use": {key: value for key, value in use.items() if value is not None}}


def _move(given: argparse.Namespace) -> dict[str, Any]:
    position = [value for value in (given.x, given.y, given.z) if value is not None]
    return {
        "entity": given.entity,
        "position": position or None,
        "orientation": _rotation(given),
        "linear": given.linear,
        "angular": given.angular,
    }


def _set(given: argparse.Namespace) -> dict[str, Any]:
    address, value = parse_set(given.input, "")
    return {"address": address, "value": value}


def execute(arguments: argparse.Namespace) -> int:
    """0 when it was done, 1 when it was refused or nothing runs."""
    given = {name: value for name, value in arguments.arguments(arguments).items() if value is not None}
    with Client(find(arguments.run)) as client:
        told = client.ask(arguments.command, given)
        state = _state(client) if arguments.command != "quit" else None
    for warning in told.get("warnings", ()) if isinstance(told, dict) else ():
        print(clean(f"warning: {warning}"), file=sys.stderr)
    if state is not None and arguments.json:
        print(json.dumps({"run": client.entry.name, "process": client.entry.pid, **state}))
    elif state is not None:
        _show(client.entry, state, robots=arguments.command in ("state", "spawn", "delete"))
    return 0


def _state(client: Client) -> dict[str, Any] | None:
    """How the session is; None if what was asked for was its last tick."""
    try:
        state: dict[str, Any] = client.ask("state")
    except ControlError:
        return None
    return state


def _show(entry: Entry, state: dict[str, Any], *, robots: bool) -> None:
    speed = state["rate"] if state["rate"] == "max" else f"{state['rate']:g}"
    print(clean(f"{entry}: {state['state']}, t = {state['time']:.3f} s, rate {speed}"))
    if robots and state["robots"]:
        print(clean(table([_robot(robot) for robot in state["robots"]], indent="  ")))
    if robots and state["objects"]:
        print(clean(f"  {listing(state['objects'], 'objects')}"))
    for node, ticks in state.get("dropped_values", {}).items() if robots else ():
        print(clean(f"  dropped bad values: in {counted(ticks, 'tick')} at {node}"))
    for command, times in state.get("clamped_commands", {}).items() if robots else ():
        print(clean(f"  clamped: {counted(times, 'command')}, {command}"))


def _robot(robot: dict[str, Any]) -> tuple[str, str, str, str]:
    """Name, namespace, where it is as seen from above, and whether it came while the session ran."""
    (x, y, _), (qx, qy, qz, qw) = robot["position"], robot["orientation"]
    yaw = math.degrees(math.atan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz)))
    place = f"at ({x:z.2f}, {y:z.2f}) m, yaw {yaw:z.0f} deg"
    return robot["name"], f"/{robot['namespace']}", place, "spawned" if robot["spawned"] else ""
