"""`graphrun ctl`: control a running simulation from another terminal."""

from __future__ import annotations

import argparse
import json
import math
import os
import re
import sys
import time
from typing import TYPE_CHECKING, Any

from graphengine.cli import terminal
from graphengine.cli.common import clean, counted, parse_set, table
from graphengine.cli.options import add_flag, add_value
from graphengine.cli.parser import Parser, add_verb
from graphengine.cli.quantities import angle, duration, number, rate, target, vector, whole
from graphengine.control.client import Client, find
from graphengine.control.runs import Entry
from graphengine.devices.rotation import yaw_of
from graphengine.format.errors import ControlError
from graphengine.format.wording import listing

if TYPE_CHECKING:
    from collections.abc import Callable

_FORCE = "place the robot even if it overlaps other objects; physics then pushes them apart"
EXAMPLES = """examples:
  graphrun run dd100_warehouse --paused  in one terminal; in another:
  graphrun ctl step 60                   run 60 ticks (one second), then pause
  graphrun ctl play
  graphrun ctl rate 0.5
  graphrun ctl why dd100                 why the robot stands still
  graphrun ctl push dd100 --force 0,80,0 --for 0.5s
  graphrun ctl fault --sensor dd100/sim_lidar --silent --for 2s
  graphrun ctl command arm --positions shoulder=0.5 elbow=90deg
  graphrun ctl move dd100 0 4 --yaw 90deg
  graphrun ctl reset-robot arm --joints shoulder=0.5
  graphrun ctl spawn second robots/dd100.yaml --at 0,6,0.03 --namespace second
  graphrun ctl set DiffController.maxLinearSpeed=0.5
  graphrun ctl save DiffController.maxLinearSpeed=0.5
  graphrun ctl reset --scope state
  graphrun ctl checkpoint before         save the state, for:
  graphrun ctl restore before

Only the user who started a run can control it, and only on the same machine;
the transport of the run does not matter. Commands are executed between two
ticks. Lengths are in m, times in s of simulation, forces in N; angles are in
rad, or in degrees when written as 90deg."""

POLL = 0.1
"""Wall time between two requests for the address of a page that is starting, s."""
_ANSWERS = ("clearance", "place", "redo", "save", "topics", "undo", "view", "why")
"""Commands whose answer is printed instead of the state of the run."""
SCOPES = ("time", "state", "spawned", "all")


_NEGATIVE = re.compile(r"-[.0-9][-+.,0-9e]*(deg|rad|s|ms|min)?(,.*)?")


class _Parser(Parser):
    """A parser that accepts values such as `-1,2,0` and `-90deg`, which argparse would take for options."""

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse arguments with a space before each negative number, so that argparse takes the number for a value."""
        words = [f" {word}" if _NEGATIVE.fullmatch(word) else word for word in args or ()]
        return super().parse_known_args(words, namespace)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun ctl` to its parser."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = EXAMPLES
    parser.set_defaults(run="", json=False)
    common = _Parser(add_help=False)
    for place in (parser, common):  # before or after the command; the latter must not replace what the former found
        which, suppressed = "run to control (default: the only one)", argparse.SUPPRESS
        add_value(place, "--run", "NAME|PID", which, default=suppressed)
        add_flag(place, "--json", "print the result as JSON", default=suppressed)
    verbs = parser.add_subparsers(dest="command", metavar="COMMAND", required=True, parser_class=_Parser)

    def add(name: str, summary: str, *fields: str, make: Callable[..., dict[str, Any]] = lambda given: {}) -> Any:
        sub = add_verb(verbs, name, summary, parents=[common])
        sub.set_defaults(arguments=lambda given: {field: getattr(given, field) for field in fields} | make(given))
        return sub

    add("state", "print the state, time, rate, robots and movable objects of the run")
    add("topics", "list the topics that the run publishes or subscribes to")
    why = add("why", "explain why a robot stands still: the first cause, and the evidence", "robot")
    why.add_argument("robot", metavar="NAME", help="name of the robot")
    add("play", "start or resume the simulation")
    add("pause", "pause the simulation")
    add("stop", "reset everything to time 0 and wait for `play` or `step`")
    add("view", "print the address of the web page that `graphrun run --view` serves")
    add("reload", "read the files of the scene again and apply their changes to the run")
    add("quit", "end the run, as Ctrl-C does")
    step = add("step", "run single ticks of a paused or stopped simulation", "ticks")
    add_value(step, "ticks", "TICKS", "number of ticks (default 1)", nargs="?", type=whole, default=1)
    reset = add("reset", "reset the simulation; a playing simulation continues to play", "scope", "seed")
    scope = "part to reset: time (clock, graphs and sensors), state (poses and joints), "
    scope += "spawned (remove spawned robots) or all (default all); may be repeated"
    reset.add_argument("--scope", choices=SCOPES, action="append", help=scope)
    reset.add_argument("--seed", type=whole, help="new seed of all random generators (default: keep the seed)")
    rate = add("rate", "set the speed of the simulation", "factor")
    add_value(rate, "factor", "FACTOR", "realtime, max, or a factor of real time, such as 0.5", type=_rate)
    _add_robots(add)
    _add_forces(add)
    put = add("set", "set an input of a node", make=_set)
    values = "unwired input, [ROBOT/][GRAPH/]NODE.PORT, and its new value; globs allowed"
    add_value(put, "input", "NODE.PORT=VALUE", values)
    written = "write the value of an input into the file that sets it, and reload; the run needs --edit"
    save = add("save", written, make=_save)
    save.add_argument("input", metavar="NODE.PORT[=VALUE]", help="input without a wire (default: its present value)")
    save.add_argument("--preview", action="store_const", const=True, help="print the change, and do not write it")
    place = add("place", "write the position of a node in drawings into its graph file", "graph", "node", "position")
    place.add_argument("graph", metavar="GRAPH", help="name of the graph, [ROBOT/]GRAPH")
    place.add_argument("node", metavar="NODE", help="name of the node in the file")
    place.add_argument("position", metavar="X,Y", type=vector(2), help="position in the key `layout`")
    add("undo", "take back the newest change of `save` or `place`, and reload")
    add("redo", "write the change that `undo` took back last, and reload")
    assign = add("assign", "set a variable of a graph", make=_assign)
    add_value(assign, "variable", "GRAPH.VARIABLE=VALUE", "variable to set, [ROBOT/]GRAPH.VARIABLE, and its new value")
    impulse = add("impulse", "trigger an OnImpulseEvent node", "node")
    add_value(impulse, "node", "NODE", "prim path of the node, or a unique suffix of it")
    for name, summary in (("press", "press keys and hold them down"), ("release", "release keys")):
        keys = add(name, summary, "keys")
        add_value(keys, "keys", "KEY", "key name of OnKeyboardInput, such as W, Space or LeftShift", nargs="+")
    marks = {
        "checkpoint": "save the complete state of the run for a later `restore`",
        "restore": "return to the state that `checkpoint` saved",
    }
    for name, summary in marks.items():
        add_value(add(name, summary, "name"), "name", "NAME", "name of the checkpoint")


def _add_robots(add: Callable[..., Any]) -> None:
    spawn = add("spawn", "add a robot to the scene", "name", "force", make=_spawn)
    add_value(spawn, "name", "NAME", "name of the robot, unique in the scene")
    file = "robot file: a path relative to the working directory, or as after `use:` in a scene file; the run must be allowed"
    file += " to read it"
    add_value(spawn, "use", "ROBOT", file)
    place = "position of the base link in the world frame, m (default 0,0,0; Z defaults to 0)"
    add_value(spawn, "--at", "X,Y[,Z]", place, type=vector(2, 3), default=(0.0, 0.0))
    _add_rotation(spawn)
    add_value(spawn, "--namespace", "NAMESPACE", "namespace of the robot's topics (default: that of the robot file)")
    add_value(spawn, "--prim", "PATH", "prim path of the robot, such as /World/robot (default: /NAME)")
    add_flag(spawn, "--robot-state", "publish the topics of robot_state_publisher for this robot")
    spawn.add_argument("--force", action="store_const", const=True, help=_FORCE)  # older runs accept no `False`
    delete = add("delete", "remove a robot from the scene", "name")
    add_value(delete, "name", "NAME", "name of the robot")
    moved = "entity", "linear", "angular", "odometry", "force"
    move = add("move", "move a robot or an object of the world", *moved, make=_move)
    add_value(move, "entity", "NAME", "name of the robot or object")
    where = "of the object, or of the robot's base link, in the world frame, m"
    for axis, meaning in (("x", f"x {where}"), ("y", f"y {where}"), ("z", f"z {where} (default: keep the height)")):
        move.add_argument(axis, metavar=axis.upper(), nargs="?", type=number, help=meaning)
    _add_rotation(move)
    for kind, unit in (("linear", "m/s"), ("angular", "rad/s")):
        velocity = f"{kind} velocity in the world frame, {unit} (default 0)"
        move.add_argument(f"--{kind}", metavar="X,Y,Z", type=vector(3), help=velocity)
    force = "place the robot or object even if it overlaps others; physics then pushes them apart"
    move.add_argument("--force", action="store_const", const=True, help=force)
    jumps = "let ground-truth odometry jump with the robot (default: it continues, as REP 105 demands)"
    move.add_argument("--odometry-jumps", action="store_const", const="jumps", dest="odometry", help=jumps)
    summary = "return one robot to its initial pose and joint positions"
    reset = add("reset-robot", summary, "keyframe", "force", make=_reset_robot)
    add_value(reset, "name", "NAME", "name of the robot")
    place = "position of the base link in the world frame, m (default: the initial position)"
    add_value(reset, "--at", "X,Y,Z", place, type=vector(3))
    _add_rotation(reset)
    positions = "positions of joints, rad or m, or as shoulder=90deg (default: the initial positions)"
    add_value(reset, "--joints", "JOINT=NUMBER", positions, nargs="+", type=target(angle), default=())
    add_value(reset, "--keyframe", "KEYFRAME", "keyframe of the robot's MuJoCo model, in place of the initial state")
    add_flag(reset, "--force", _FORCE)
    summary = "print all that would be close to a robot or object at another position, in any heading"
    clearance = add("clearance", summary, "entity", "position", "margin")
    add_value(clearance, "entity", "NAME", "name of the robot or object")
    there = "position of the object, or of the robot's base link, in the world frame, m"
    add_value(clearance, "position", "X,Y", there, type=vector(2))
    far = "distance up to which obstacles are printed, m (default 0)"
    add_value(clearance, "--margin", "DISTANCE", far, type=number, default=0.0)


def _add_forces(add: Callable[..., Any]) -> None:
    push = add("push", "apply a force or impulse to a robot or object", "entity", "force", "impulse", "duration", "at")
    add_value(push, "entity", "NAME", "name of the robot or object")
    one = push.add_mutually_exclusive_group(required=True)
    add_value(one, "--force", "X,Y,Z", "force in the world frame, N", type=vector(3))
    add_value(one, "--impulse", "X,Y,Z", "impulse in the world frame, N s", type=vector(3))
    how_long = "simulation time, such as 0.5s or 200ms; required for a force (default for an impulse: one tick)"
    add_value(push, "--for", "TIME", how_long, dest="duration", type=duration)
    point = "point of application in the world frame, m (default: centre of mass)"
    add_value(push, "--at", "X,Y,Z", point, type=vector(3))

    summary = "let a sensor or a topic fail: silent, late, or with dropouts"
    fault = add("fault", summary, "sensor", "topic", "silent", "dropout", "delay", "duration")
    mend = add("mend", "end the fault of a sensor or a topic (default: all faults)", "sensor", "topic")
    for verb, required in ((fault, True), (mend, False)):
        one = verb.add_mutually_exclusive_group(required=required)
        add_value(one, "--sensor", "ROBOT/SENSOR", "name of the sensor, or the path of its prim")
        where = "full name of a topic; the fault acts where graphs publish it, or else where graphs receive it"
        add_value(one, "--topic", "TOPIC", where)
    fault.add_argument("--silent", action="store_const", const=True, help="lose all samples or messages")
    share = "probability with which a sample or message is lost, such as 0.2; the seed determines which ones are lost"
    add_value(fault, "--dropout", "SHARE", share, type=number)
    late = "time by which samples or messages arrive later, such as 300ms; their stamps do not change"
    add_value(fault, "--delay", "TIME", late, type=duration)
    end = "simulation time after which the fault ends, such as 2s (default: `mend` or a reset ends it)"
    add_value(fault, "--for", "TIME", end, dest="duration", type=duration)

    command = add("command", "set targets of a robot's joints from the next tick on", "robot", make=_command)
    add_value(command, "robot", "NAME", "name of the robot")
    kinds = {
        "positions": "position targets, rad or m, or as shoulder=90deg; the joints need drives with stiffness",
        "velocities": "velocity targets, rad/s or m/s; the joints need drives with damping",
        "efforts": "torques or forces, N m or N, in addition to those of the drives",
    }
    for kind, meaning in kinds.items():
        read = target(angle if kind == "positions" else number)
        command.add_argument(f"--{kind}", metavar="JOINT=NUMBER", nargs="+", type=read, help=meaning)


def _add_rotation(parser: argparse.ArgumentParser) -> None:
    one = parser.add_mutually_exclusive_group()
    add_value(one, "--yaw", "ANGLE", "rotation about the world's z axis, rad or as 90deg", type=angle)
    rpy = "roll, pitch, yaw about the fixed axes of the world, as in URDF, rad or as 90deg"
    add_value(one, "--rpy", "R,P,Y", rpy, type=vector(3, item=angle))
    add_value(one, "--quaternion", "X,Y,Z,W", "orientation as a quaternion, scalar last", type=vector(4))


def _rotation(given: argparse.Namespace) -> dict[str, Any] | None:
    """Return the orientation given by the options, as in a scene file; None if the options give none."""
    if given.quaternion is not None:
        return {"quaternion_xyzw": given.quaternion}
    turned = given.rpy if given.rpy is not None else (0.0, 0.0, given.yaw) if given.yaw is not None else None
    return {"rpy_deg": [math.degrees(value) for value in turned]} if turned is not None else None


def _rate(text: str) -> float | str:
    """Return a rate as a value for JSON: a factor of real time, or `max`."""
    factor = rate(text)
    return "max" if math.isinf(factor) else factor


def _spawn(given: argparse.Namespace) -> dict[str, Any]:
    """Return the arguments of the command `spawn`; the path of an existing robot file becomes absolute."""
    use: dict[str, Any] = {
        "use": os.path.abspath(given.use) if os.path.isfile(given.use) else given.use,
        "at": given.prim,
        "position": (*given.at, 0.0)[:3],
        "orientation": _rotation(given),
        "namespace": given.namespace,
        "robot_state": given.robot_state,
    }
    return {"use": {key: value for key, value in use.items() if value is not None}}


def _move(given: argparse.Namespace) -> dict[str, Any]:
    position = [value for value in (given.x, given.y, given.z) if value is not None]
    return {"position": position or None, "orientation": _rotation(given)}


def _reset_robot(given: argparse.Namespace) -> dict[str, Any]:
    where = {"position": given.at, "orientation": _rotation(given)}
    return {"robot": given.name, "joints": dict(given.joints), **where}


def _command(given: argparse.Namespace) -> dict[str, Any]:
    kinds = ("positions", "velocities", "efforts")
    return {kind: dict(getattr(given, kind)) for kind in kinds if getattr(given, kind) is not None}


def _assign(given: argparse.Namespace) -> dict[str, Any]:
    target, value = parse_set(given.variable, "")
    graph, _, variable = target.rpartition(".")
    return {"graph": graph, "variable": variable, "value": value}


def _save(given: argparse.Namespace) -> dict[str, Any]:
    address, value = parse_set(given.input, "") if "=" in given.input else (given.input, None)
    return {
        "address": address,
        **({} if value is None else {"value": value}),
        **({"preview": True} if given.preview else {}),
    }


def _set(given: argparse.Namespace) -> dict[str, Any]:
    address, value = parse_set(given.input, "")
    return {"address": address, "value": value}


def execute(arguments: argparse.Namespace) -> int:
    """Send the command to the run and print its result; return 0.

    Raises:
        ControlError: there is no run to control, or the run refused the command.
        UsageError: several runs match `--run`.
    """
    given = {name: value for name, value in arguments.arguments(arguments).items() if value is not None}
    with Client(find(arguments.run)) as client:
        told = client.ask(arguments.command, given)
        while arguments.command == "view" and not told["page"]:
            time.sleep(POLL)
            told = client.ask("view", {"waiting": True})
        state = _state(client) if arguments.command not in ("quit", *_ANSWERS) else None
    for warning in told.get("warnings", ()) if isinstance(told, dict) else ():
        print(clean(f"warning: {warning}"), file=sys.stderr)
    if arguments.json:
        result = told if arguments.command in ("reload", *_ANSWERS) else None
        print(json.dumps(result or {"run": client.entry.name, "process": client.entry.pid, **(state or {})}))
        return 0
    if arguments.command == "view":
        print(clean(told["page"]))
    elif arguments.command in ("place", "redo", "reload", "save", "undo"):
        print(clean(told["text"]))
    elif arguments.command == "topics":
        print(clean("\n".join(told["topics"])))
    elif arguments.command == "why":
        print(clean("\n  ".join((told["sentence"], *told["evidence"]))))
    elif arguments.command == "clearance":
        near = [(name, f"{distance:.3f} m" if distance else "overlaps") for name, distance in told["near"].items()]
        print(clean(table(near) if near else "nothing stands there"))
    if state is not None:
        _show(client.entry, state, robots=arguments.command in ("state", "spawn", "delete"))
    return 0


def _state(client: Client) -> dict[str, Any] | None:
    """Return the state of the run; None if the run has ended."""
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
        print(terminal.wrapped(clean(f"  {listing(state['objects'], 'objects')}"), sys.stdout))
    if state.get("findings"):
        errors = counted(len(state["findings"]), "error")
        print(f"  {errors} in changed files; the run continues with the previous version")
    for name in state.get("faults", ()) if robots else ():
        print(clean(f"  fault: {name}"))
    for node, ticks in state.get("dropped_values", {}).items() if robots else ():
        print(clean(f"  dropped bad values: in {counted(ticks, 'tick')} at {node}"))
    for command, times in state.get("clamped_commands", {}).items() if robots else ():
        print(clean(f"  clamped: {counted(times, 'command')}, {command}"))


def _robot(robot: dict[str, Any]) -> tuple[str, str, str, str]:
    """Return the cells of a robot in the table: name, namespace, position (m) with yaw (deg), and `spawned` or nothing."""
    (x, y, _), yaw = robot["position"], math.degrees(yaw_of(robot["orientation"]))
    place = f"at ({x:z.2f}, {y:z.2f}) m, yaw {yaw:z.0f} deg"
    return robot["name"], f"/{robot['namespace']}", place, "spawned" if robot["spawned"] else ""
