"""The rows of the interop matrix: each function runs one cell against a real node of rclpy and returns its figures.

A function raises `CellError` when its bar is missed. Bars are about function, as machines differ: all reliable messages arrive,
with their values. In the figures `->` is from ours to ROS 2, `<-` the other way, and times are medians.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

from graphengine.messages.endpoints import EndpointClaim, QoS
from graphengine.messages.goals import CANCELED, SUCCEEDED
from graphengine.messages.messages import TFMessage, TransformStamped, decode, encode, header
from graphengine.messages.qos import LATCHED
from graphengine.ros.action_caller import ActionCaller
from graphengine.ros.network import LiveNetwork
from graphengine.ros.tf_tree import FrameTree
from tests.action_graph import FIBONACCI, GOAL, SERVER
from tests.interop.ends import Cell, CellError, Ours, Peer, Run, UnreachableError, seconds_until
from tests.interop.samples import GREETING, TYPES, Tally

TOPIC, SERVICE, ACTION = "/interop/topic", "/interop/service", "/fibonacci"
SET_BOOL = "std_srvs/srv/SetBool"
HINT = "--transport rclpy"
"""What a warning about an unreachable peer says to use."""
QUIET = 15.0
"""Seconds without another message after which no more are expected."""
CALLS = 100
TF = "tf2_msgs/msg/TFMessage"


def publish(cell: Cell) -> str:
    peer, begun = cell.peer(), time.monotonic()
    return forth(cell.ours(), peer, "text", 100, 50.0, begun=begun)


def subscribe(cell: Cell) -> str:
    peer, begun = cell.peer(), time.monotonic()
    return back(cell.ours(), peer, "text", 100, 50.0, begun=begun)


def wide_strings(cell: Cell) -> str:
    return both_ways(cell, "wide", 20, 20.0)


def sequences(cell: Cell) -> str:
    ours, peer = cell.ours(), cell.peer()
    ways = (way(ours, peer, kind, 20, 20.0, topic=f"{TOPIC}/{kind}") for kind in SEQUENCES for way in (forth, back))
    return "; ".join(f"{SEQUENCES[index // 2]}: {figures}" for index, figures in enumerate(ways))


SEQUENCES = ("bounded", "unbounded")


def thousand_hertz(cell: Cell) -> str:
    return both_ways(cell, "text", 3000, 1000.0, QoS(depth=3000))


def megabyte(cell: Cell) -> str:
    return large(cell, 2**20, 60, 10.0)


def four_megabytes(cell: Cell) -> str:
    return large(cell, 2**22, 20, 4.0)


def large(cell: Cell, size: int, count: int, rate: float) -> str:
    """Send large messages reliably, all of which must arrive, and as best effort, which is a figure."""
    ours, peer = cell.ours(), cell.peer()
    reliable = "; ".join(way(ours, peer, "image", count, rate, QoS(depth=count), size) for way in (forth, back))
    loose = QoS(depth=5, reliability="bestEffort")
    arguments = "image", count, rate, loose, size, f"{TOPIC}/loose"
    return f"reliable: {reliable}; best effort: {'; '.join(way(ours, peer, *arguments) for way in (forth, back))}"


def both_ways(cell: Cell, kind: str, count: int, rate: float, qos: QoS | None = None) -> str:
    ours, peer = cell.ours(), cell.peer()
    return "; ".join(way(ours, peer, kind, count, rate, qos) for way in (forth, back))


def forth(
    ours: Ours,
    peer: Peer,
    kind: str,
    count: int,
    rate: float,
    qos: QoS | None = None,
    size: int = 0,
    topic: str = TOPIC,
    begun: float | None = None,
) -> str:
    """Send from ours to ROS 2; `begun` is since when they look for each other, if not since now."""
    qos, topic, begun = qos or QoS(), f"{topic}/forth", begun or time.monotonic()
    peer.listen(topic=topic, kind=kind, size=size, **profile(qos))
    writer = ours.transport.writer(topic, TYPES[kind], qos)
    seconds_until(lambda: writer.matched and peer.matched(topic=topic)["matched"], "both ends find each other")
    found = time.monotonic() - begun
    took = ours.send(writer, kind, count, rate, size)
    report = settled(lambda: peer.heard(topic=topic), count)
    writer.close()
    return arrived("->", report, count, took, found, is_sure=qos.reliability == "reliable")


def back(
    ours: Ours,
    peer: Peer,
    kind: str,
    count: int,
    rate: float,
    qos: QoS | None = None,
    size: int = 0,
    topic: str = TOPIC,
    begun: float | None = None,
) -> str:
    """Send from ROS 2 to ours."""
    qos, topic, begun = qos or QoS(), f"{topic}/back", begun or time.monotonic()
    tally = ours.listen(topic, kind, qos, size)
    peer.talk(topic=topic, kind=kind, **profile(qos))
    ends = ours.transport.graph
    seconds_until(
        lambda: ends().publishers(topic) and peer.matched(topic=topic)["matched"], "both ends find each other"
    )
    found = time.monotonic() - begun

    def greet() -> bool:
        peer.send(topic=topic, kind=kind, count=1, rate=1.0, size=size, first=GREETING)
        return tally.greeted.wait(1.0)

    # The peer cannot report when our reader is matched, and Fast DDS may lose the first large message to Cyclone DDS.
    seconds_until(greet, "a first message arrives")
    took = peer.send(topic=topic, kind=kind, count=count, rate=rate, size=size)["seconds"]
    report = settled(tally.report, count)
    return arrived("<-", report, count, took, found, is_sure=qos.reliability == "reliable")


def profile(qos: QoS) -> dict[str, Any]:
    """Return a profile as the peer's commands take it."""
    reliable, latched = qos.reliability == "reliable", qos.durability == "transientLocal"
    return {"depth": qos.depth, "reliable": reliable, "latched": latched, "deadline": qos.deadline}


def settled(heard: Callable[[], dict[str, Any]], count: int) -> dict[str, Any]:
    """Return a report once all messages are received, or none comes any more."""
    report, quiet = heard(), time.monotonic()
    while report["received"] < count and time.monotonic() - quiet < QUIET:
        time.sleep(0.05)
        later = heard()
        quiet = time.monotonic() if later["received"] > report["received"] else quiet
        report = later
    return report


def arrived(way: str, report: dict[str, Any], count: int, took: float, found: float, *, is_sure: bool) -> str:
    """Return the figures of a report.

    Raises:
        CellError: a reliable message is missing, or a message is broken or received twice.
    """
    rate, age = f"{count / took:.0f} Hz", f"{report['median']:.1f} ms"
    figures = f"{way} {report['received']}/{count} at {rate}, {age}, found in {found:.2f} s"
    if report["broken"] or report["twice"] or (is_sure and report["received"] < count):
        first = f"first received: {report['first']}"
        raise CellError(f"{figures}; broken: {report['broken']}, received twice: {report['twice']}, {first}")
    return figures


def service_server(cell: Cell) -> str:
    ours, peer = cell.ours(), cell.peer()

    def answer(request_id: bytes, data: bytes) -> None:
        response = ours.definitions.initial(f"{SET_BOOL}_Response")
        response.success, response.message = decode(data, f"{SET_BOOL}_Request", ours.definitions).data, "Grüße"
        server.answer(request_id, encode(response, ours.definitions))

    server = ours.transport.server(SERVICE, SET_BOOL, QoS(), answer)
    outcome = peer.call(service=SERVICE, count=CALLS)
    if not outcome["answered"]:
        raise unreachable("a ROS 2 client gets no response", *ours.transport.foreign_services.values())
    return answered(outcome["answered"], outcome["times"], outcome["found"])


def service_client(cell: Cell) -> str:
    ours, peer = cell.ours(), cell.peer()
    peer.serve(service=SERVICE)
    answers: dict[int, Any] = {}

    def keep(number: int, data: bytes) -> None:
        answers[number] = decode(data, f"{SET_BOOL}_Response", ours.definitions)

    client = ours.transport.client(SERVICE, SET_BOOL, QoS(), keep)
    try:
        found = seconds_until(lambda: client.ready, "graphengine discovers the ROS 2 server")
    except CellError as error:
        raise unreachable(str(error), *ours.transport.foreign_services.values()) from None
    times, right = list[float](), 0
    for number in range(CALLS):
        request = ours.definitions.initial(f"{SET_BOOL}_Request")
        request.data = number % 2 == 0
        call = client.call(encode(request, ours.definitions))
        times.append(1e3 * seconds_until(lambda call=call: call in answers, "a call is answered"))  # type: ignore[misc]
        right += answers[call].message == "Grüße" and answers[call].success == request.data
    return answered(right, times, found)


def answered(right: int, times: list[float], found: float) -> str:
    """Return the figures of calls.

    Raises:
        CellError: an answer is missing or wrong.
    """
    figures = f"{right}/{CALLS} calls, {sorted(times)[len(times) // 2]:.1f} ms, found in {found:.2f} s"
    if right < CALLS:
        raise CellError(figures)
    return figures


def action_server(cell: Cell) -> str:
    run = graph(cell, SERVER.replace("duration: 3", "duration: 60"))
    peer = cell.peer()
    outcome = peer.pursue(action=ACTION, order=5)
    if not outcome["answered"]:
        raise unreachable("a ROS 2 client gets no response", run.said)
    return pursued(outcome, [0, 1, 1])


def action_client(cell: Cell) -> str:
    ours, peer, feedback = cell.ours(), cell.peer("--threads"), list[Any]()
    peer.offer(action=ACTION)
    caller = ActionCaller(ours.transport, ACTION, FIBONACCI)
    try:
        found = seconds_until(lambda: caller.ready, "graphengine discovers the ROS 2 server")
    except CellError as error:
        raise unreachable(str(error), *ours.transport.foreign_services.values()) from None
    begun = time.monotonic()
    done = caller.send(GOAL(5), feedback.append).result.result(60.0)
    lasted = time.monotonic() - begun
    endless = caller.send(GOAL(1000))
    if not endless.accepted.result(60.0):
        raise CellError("the second goal is rejected")
    caller.cancel(endless.goal).result(60.0)
    status = [done.status, endless.result.result(60.0).status]
    outcome = {"found": found, "status": status, "sequence": list(done.result.sequence), "feedback": len(feedback)}
    return pursued({**outcome, "seconds": lasted}, [0, 1, 1, 2, 3, 5, 8])


def pursued(outcome: dict[str, Any], sequence: list[int]) -> str:
    """Return the figures of a goal that succeeds and one that is cancelled.

    Raises:
        CellError: a goal ended otherwise.
    """
    if outcome["status"] != [SUCCEEDED, CANCELED] or outcome["sequence"] != sequence or not outcome["feedback"]:
        raise CellError(f"goals ended as {outcome}")
    counts = f"{outcome['feedback']} feedback messages{lost_at_first(outcome)}"
    return f"1 succeeded in {outcome['seconds']:.1f} s, 1 cancelled, {counts}, found in {outcome['found']:.2f} s"


def parameters(cell: Cell) -> str:
    run = cell.run("graphs/clock.yaml", "--simulation-interfaces")
    outcome = cell.peer().parameters(node="/clock", name="real_time_factor", value=0.5)
    if not outcome["answered"]:
        raise unreachable("a ROS 2 client gets no response", run.said)
    wanted = {"listed": True, "described": True, "type": [3], "set": True, "value": 0.5}
    if {name: outcome[name] for name in wanted} != wanted or not outcome["refused"]:
        raise CellError(f"the parameter services answer {outcome}")
    return f"all 6 services, bad value refused{lost_at_first(outcome)}, found in {outcome['found']:.2f} s"


def lost_at_first(outcome: dict[str, Any]) -> str:
    """Return how many calls were sent again because they were not answered; empty if none was."""
    return f", repeated calls: {outcome['lost']}" if outcome.get("lost") else ""


def graph(cell: Cell, text: str) -> Run:
    """Run a graph."""
    path = cell.folder / "graph.yaml"
    path.write_text(f"format: 1\ngraph: graph\n{text}", "utf-8")
    return cell.run(str(path), "--no-control")


def unreachable(what: str, *told: str) -> CellError:
    """Return the error for peers that are not found; `UnreachableError` if the user was told what to do."""
    return (
        UnreachableError(what) if any(HINT in text for text in told) else CellError(f"{what}, and no hint is printed")
    )


def transforms(cell: Cell) -> str:
    ours, peer, count = cell.ours(), cell.peer(), 50
    static, moving = (
        ours.transport.writer(topic, TF, qos) for topic, qos in (("/tf_static", LATCHED), ("/tf", QoS(depth=100)))
    )
    ending = threading.Event()

    def broadcast() -> None:
        number = 0
        while not ending.wait(0.02):
            number = min(number + 1, count)
            moving.write(transform("odom", "base_link", number))

    static.write(transform("map", "odom", 1))
    thread = threading.Thread(target=broadcast)
    thread.start()
    try:
        outcome = peer.look_up(target="map", source="base_link", count=count)
    finally:
        ending.set()
        thread.join()
    if outcome["x"] != count + 1.0:
        raise CellError(f"tf2_ros does not find base_link in map: {outcome}")
    static.close()
    moving.close()
    return f"-> map to base_link by tf2_ros, found in {outcome['found']:.2f} s; <- {tree(cell)}"


def transform(parent: str, child: str, number: int) -> bytes:
    """Return a message with the transform of a number's time, 10 ms each."""
    made: Any = TransformStamped(header(number * 0.01, parent), child, identity().transform)
    made.transform.translation.x = float(number)
    return encode(TFMessage([made]))


def identity() -> Any:
    from graphengine.messages.definitions import DEFINITIONS

    return DEFINITIONS.initial("geometry_msgs/msg/TransformStamped")


def tree(cell: Cell) -> str:
    """Return the figures of a tree of frames that a node of ROS 2 broadcasts, in a new pair of nodes."""
    ours, peer, frames, lock = cell.ours("interop_frames"), cell.peer(), FrameTree(), threading.Lock()

    def add(data: bytes, static: bool) -> None:
        with lock:
            frames.add(decode(data, TF), static, ours.transport.source)

    ours.transport.reader("/tf_static", TF, LATCHED, lambda data: add(data, True))
    ours.transport.reader("/tf", TF, QoS(depth=100), lambda data: add(data, False))
    peer.broadcast(count=200, rate=50.0)

    def edges() -> set[tuple[str, str]]:
        with lock:
            return {(edge.parent, edge.child) for edge in frames.edges}

    found = seconds_until(
        lambda: edges() >= {("map", "odom"), ("odom", "base_link")}, "map, odom and base_link are heard"
    )
    return f"map, odom and base_link in {found:.1f} s"


def latched(cell: Cell) -> str:
    """The last message reaches who comes late, on both sides."""
    ours, peer = cell.ours(), cell.peer()
    writer = ours.transport.writer(f"{TOPIC}/forth", TYPES["text"], LATCHED)
    ours.send(writer, "text", 3, 50.0)
    peer.talk(topic=f"{TOPIC}/back", kind="text", **profile(LATCHED))
    peer.send(topic=f"{TOPIC}/back", kind="text", count=3, rate=50.0)
    begun = time.monotonic()
    peer.listen(topic=f"{TOPIC}/forth", kind="text", **profile(LATCHED))
    forth = first(lambda: peer.heard(topic=f"{TOPIC}/forth"), begun, 2)
    begun = time.monotonic()
    back = first(ours.listen(f"{TOPIC}/back", "text", LATCHED).report, begun, 2)
    return f"-> the last of 3 after {forth:.1f} s; <- the last of 3 after {back:.1f} s"


def first(heard: Callable[[], dict[str, Any]], begun: float, number: int | None = None) -> float:
    """Return the seconds until a first message; it must be the given one."""
    seconds_until(lambda: heard()["received"], "the first message")
    seconds, report = time.monotonic() - begun, heard()
    if number is not None and (report["first"], report["last"]) != (number, number):
        raise CellError(f"the first message is number {report['first']}, not {number}")
    return seconds


def qos_events(cell: Cell) -> str:
    """Both sides are told of a pair that does not match; a reader of ROS 2 learns of missed deadlines."""
    ours, peer, told = cell.ours(), cell.peer(), list[str]()
    network = LiveNetwork(lambda _: ours.transport, 0, told.append)
    loose = QoS(reliability="bestEffort")
    for direction, qos, topic in (("publish", loose, f"{TOPIC}/forth"), ("subscribe", QoS(), f"{TOPIC}/back")):
        claim = EndpointClaim("/World/node", "graph", topic, TYPES["text"], direction, qos)
        (network.publisher if direction == "publish" else network.subscription)(claim)
    peer.listen(topic=f"{TOPIC}/forth", kind="text", **profile(QoS()))
    peer.talk(topic=f"{TOPIC}/back", kind="text", **profile(loose))

    def complete() -> bool:
        network.freeze()
        network.flush()
        named = [text for text in told if "reliable" in text and "bestEffort" in text]
        return len(named) >= 2 and peer.events()["events"].count("incompatible") >= 2

    found = seconds_until(complete, "both sides report both pairs that do not match")
    deadline = QoS(deadline=0.2)
    peer.listen(topic=f"{TOPIC}/late", kind="text", **profile(deadline))
    writer = ours.transport.writer(f"{TOPIC}/late", TYPES["text"], deadline)
    seconds_until(
        lambda: writer.matched and peer.matched(topic=f"{TOPIC}/late")["matched"], "both ends find each other"
    )
    ours.send(writer, "text", 5, 20.0)
    missed = seconds_until(
        lambda: "deadline" in peer.events()["events"], "a reader of ROS 2 learns of a missed deadline"
    )
    network.close()
    return f"2 mismatches reported to both sides in {found:.1f} s; missed deadline reported after {missed:.1f} s"


def late_joiner(cell: Cell) -> str:
    """From its first message on, a node that comes late misses none."""
    ours = cell.ours()
    writer = ours.transport.writer(f"{TOPIC}/forth", TYPES["text"], QoS(depth=500))
    thread = threading.Thread(target=ours.send, args=(writer, "text", 500, 50.0))
    thread.start()
    begun = time.monotonic()
    peer = cell.peer()
    peer.listen(topic=f"{TOPIC}/forth", kind="text", depth=500)
    forth = first(lambda: peer.heard(topic=f"{TOPIC}/forth"), begun)
    thread.join()
    to_ros = gapless(lambda: peer.heard(topic=f"{TOPIC}/forth"), 500)
    peer.talk(topic=f"{TOPIC}/back", kind="text", depth=500)
    peer.stream(topic=f"{TOPIC}/back", kind="text", count=500, rate=50.0)
    seconds_until(lambda: peer.sent(topic=f"{TOPIC}/back")["last"] >= 50, "messages are sent")
    begun = time.monotonic()
    tally = cell.ours("interop_late").listen(f"{TOPIC}/back", "text", QoS(depth=500))
    back = first(tally.report, begun)
    return f"-> after {forth:.1f} s, then {to_ros}; <- after {back:.1f} s, then {gapless(tally.report, 500)}"


def gapless(heard: Callable[[], dict[str, Any]], count: int) -> str:
    """Return how many messages came from the first to the last one.

    Raises:
        CellError: one is missing.
    """
    seconds_until(lambda: heard()["last"] == count - 1, "the last message", 30.0)
    report = heard()
    wanted = report["last"] - report["first"] + 1
    if report["received"] != wanted:
        raise CellError(f"{report['received']} of {wanted} messages after the first one")
    return f"{wanted}/{wanted}"


def killed_peer(cell: Cell) -> str:
    """A peer that is killed is forgotten, holds nothing up, and another takes its place."""
    ours, peer = cell.ours(), cell.peer()
    peer.listen(topic=TOPIC, kind="text")
    writer = ours.transport.writer(TOPIC, TYPES["text"], QoS())
    seconds_until(lambda: writer.matched and peer.matched(topic=TOPIC)["matched"], "both ends find each other")
    peer.kill()
    begun, longest = time.monotonic(), 0.0
    while writer.matched:
        before = time.monotonic()
        ours.send(writer, "text", 1, 1.0)
        longest = max(longest, time.monotonic() - before)
        if time.monotonic() - begun > 60.0:
            raise CellError("the killed peer is not forgotten within 60 s")
        time.sleep(0.02)
    gone, other = time.monotonic() - begun, cell.peer()
    figures = f"forgotten after {gone:.0f} s, longest write {1e3 * longest:.0f} ms"
    return f"{figures}; next peer: {forth(ours, other, 'text', 50, 50.0)}"


def restarted_nodes(cell: Cell) -> str:
    """Messages cross again after a node of each side was closed and opened again under its name."""
    ours, peer = cell.ours(), cell.peer()
    both = [f"{forth(ours, peer, 'text', 20, 50.0)}; {back(ours, peer, 'text', 20, 50.0)}"]
    ours.transport.close()
    ours = cell.ours()
    both.append(again(ours, peer))
    peer.end()
    both.append(f"{forth(ours, cell.peer(), 'text', 20, 50.0)}")
    return f"graphengine restarted: {both[1]}; peer restarted: {both[2]}"


def again(ours: Ours, peer: Peer) -> str:
    """Send to the reader, and from the writer, that a peer has from before."""
    writer, tally = (
        ours.transport.writer(f"{TOPIC}/forth", TYPES["text"], QoS()),
        ours.listen(f"{TOPIC}/back", "text", QoS()),
    )
    found = seconds_until(lambda: writer.matched, "the peer is found again")
    before = peer.heard(topic=f"{TOPIC}/forth")["twice"]

    def heard() -> bool:
        ours.send(writer, "text", 1, 1.0)
        peer.send(topic=f"{TOPIC}/back", kind="text", count=1, rate=1.0)
        return peer.heard(topic=f"{TOPIC}/forth")["twice"] > before and crossed(tally)

    seconds_until(heard, "messages cross again")
    return f"both ways, found in {found:.2f} s"


def crossed(tally: Tally) -> bool:
    return bool(tally.report()["received"])


ROWS: dict[str, Callable[[Cell], str]] = {
    "publisher": publish,
    "subscription": subscribe,
    "service server": service_server,
    "service client": service_client,
    "action server": action_server,
    "action client": action_client,
    "parameters": parameters,
    "tf": transforms,
    "latched": latched,
    "QoS events": qos_events,
    "wstring": wide_strings,
    "bounded and unbounded sequences": sequences,
    "1 MB messages": megabyte,
    "4 MB messages": four_megabytes,
    "1000 Hz": thousand_hertz,
    "late joiner": late_joiner,
    "kill -9 of the peer": killed_peer,
    "node restart": restarted_nodes,
}
"""The cells of a column; a server, client, publisher or subscription is ours, its peer is a node of ROS 2."""
COLUMNS = [(kind, rmw) for kind in ("dds", "rclpy") for rmw in ("rmw_cyclonedds_cpp", "rmw_fastrtps_cpp")]
"""Our transports, and the RMWs of their peers."""
MAY_FAIL = {(row, "dds", "rmw_fastrtps_cpp") for row in (*tuple(ROWS)[2:6], "parameters")}
"""Services, actions and parameters do not cross between Cyclone DDS, which is embedded, and Fast DDS."""
