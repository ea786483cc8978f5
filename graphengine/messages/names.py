"""Builds and checks ROS 2 names of topics, services, actions, namespaces and nodes, by the rules of rcl."""

from __future__ import annotations

import re
from collections.abc import Iterable

from graphengine.format.errors import TopicError

MAX_TOPIC = 247
"""Maximum length of a topic name: DDS allows 255 characters, of which ROS 2 reserves 8 for its prefixes."""
MAX_NAMESPACE = MAX_TOPIC - 2
"""Maximum length of a namespace; it leaves room for a slash and a topic name of one character."""
MAX_NODE = 255
"""Maximum length of the name of a ROS 2 node, characters."""
ACTION_PART = "/_action/"
"""Text between the name of an action and the role of its service or topic, as in `/dock/_action/feedback`."""

_PARTS_HELP = "legal: letters A-Z a-z, digits and _, in parts separated by /; no part is empty or starts with a digit"
_NODE_HELP = "legal: letters A-Z a-z, digits and _; the first is not a digit"

_ENDS = re.compile(r"\A[\W_]+|[\W_]+\Z")
_PUNCTUATION_AT_ENDS = re.compile(r"\A\W+|\W+\Z")
_ILLEGAL_IN_TOPIC = re.compile(r"[^A-Za-z0-9_/]")
_ILLEGAL_IN_NODE = re.compile(r"[^A-Za-z0-9_]")


def strip(name: str) -> str:
    """Return a name without the slashes, underscores, blanks and other characters at both ends that are not letters or digits.

    Letters of other alphabets stay; `check_topic` reports them.
    """
    return _ENDS.sub("", name)


def full_namespace(namespace: str) -> str:
    """Return the absolute form of a namespace, to which `/TOPIC` can be appended, such as `/arm`; empty for the root."""
    stripped = strip(namespace)
    return f"/{stripped}" if stripped else ""


def full_topic(namespace: str, topic: str, what: str = "topic name") -> str:
    """Return the absolute name of a topic or service in a namespace; a leading slash of `topic` is ignored.

    Args:
        namespace: namespace; empty for the root.
        topic: name of the topic or service in the namespace.
        what: kind of the name, for the error message.

    Raises:
        TopicError: the namespace or the name is not legal in ROS 2.
    """
    above = full_namespace(namespace)
    if above:
        check_namespace(above, given=namespace)
    below = strip(topic)
    if not below:
        raise TopicError(f"{what} {topic!r} has no letter or digit", topic, _PARTS_HELP)
    full = f"{above}/{below}"
    check_topic(full, given=topic, what=what)
    return full


def join_namespaces(values: Iterable[str], outermost: bool = False) -> str:
    """Return the namespaces of a prim and its ancestors, joined by slashes.

    Args:
        values: namespaces from the root of the stage to the prim; empty namespaces are ignored.
        outermost: whether to return only the outermost namespace, as TF nodes need it.
    """
    authored = [value for value in (_PUNCTUATION_AT_ENDS.sub("", value) for value in values) if value]
    return "/".join(authored[:1] if outermost else authored)


def node_name(prim_path: str) -> str:
    """Return a ROS node name for a prim path, with illegal characters replaced by underscores."""
    return _ILLEGAL_IN_NODE.sub("_", prim_path)


def service_topics(service: str) -> tuple[str, str]:
    """Return the names of the DDS topics for the requests and the responses of a service."""
    return f"rq{service}Request", f"rr{service}Reply"


def action_of(name: str) -> str:
    """Return the name of the action to which a service or topic with this name belongs; empty if the name is not of an action."""
    action, separator, part = name.rpartition(ACTION_PART)
    return action if separator and part in ("send_goal", "cancel_goal", "get_result", "feedback", "status") else ""


def ros_name(dds_topic: str) -> str:
    """Return the ROS name of the topic or service to which a DDS topic belongs; other DDS topics keep their names."""
    prefix, slash, rest = dds_topic.partition("/")
    suffix = {"rt": "", "rq": "Request", "rr": "Reply"}.get(prefix)
    return f"/{rest.removesuffix(suffix)}" if slash and suffix is not None else dds_topic


def check_topic(name: str, given: str | None = None, what: str = "topic name") -> None:
    """Check the absolute name of a topic or service by rcl's rules.

    Args:
        name: absolute name.
        given: name that the user wrote, if it differs from `name`.
        what: kind of the name, for the error message.

    Raises:
        TopicError: the name is not legal; the message gives the position of the fault and the rule.
    """
    _refuse(what, name, given, _fault_in_parts(name, MAX_TOPIC), _PARTS_HELP)


def check_namespace(name: str, given: str | None = None) -> None:
    """Check an absolute namespace by rcl's rules; `/` alone is legal. Arguments and errors are those of `check_topic`."""
    fault = "" if name == "/" else _fault_in_parts(name, MAX_NAMESPACE)
    _refuse("namespace", name, given, fault, _PARTS_HELP)


def check_node_name(name: str, given: str | None = None) -> None:
    """Check a node name by rcl's rules. Arguments and errors are those of `check_topic`."""
    fault = _empty_or_illegal(name, _ILLEGAL_IN_NODE)
    if not fault and name[0].isdigit():
        fault = f"starts with the digit {name[0]!r}"
    _refuse("node name", name, given, fault or _too_long(name, MAX_NODE), _NODE_HELP)


def _refuse(what: str, name: str, given: str | None, fault: str, legal: str) -> None:
    if not fault:
        return
    written = name if given is None else given
    origin = "" if written == name else f" (from {_shortened(written)})"
    raise TopicError(f"{what} {_shortened(name)}{origin} {fault}", written, legal)


def _fault_in_parts(name: str, limit: int) -> str:
    fault = _empty_or_illegal(name, _ILLEGAL_IN_TOPIC)
    if fault:
        return fault
    if name[0] != "/":
        return "does not start with '/'"
    if name[-1] == "/":
        return "ends with '/'"
    position = 2
    for part in name[1:].split("/"):
        if not part:
            return f"has two slashes in a row at character {position - 1}"
        if part[0].isdigit():
            return f"has a part that starts with the digit {part[0]!r} at character {position}"
        position += len(part) + 1
    return _too_long(name, limit)


def _empty_or_illegal(name: str, illegal: re.Pattern[str]) -> str:
    if not name:
        return "is empty"
    found = illegal.search(name)
    return f"has {found.group()!r} at character {found.start() + 1}" if found else ""


def _too_long(name: str, limit: int) -> str:
    return f"has {len(name)} characters, at most {limit} are allowed" if len(name) > limit else ""


def _shortened(name: str) -> str:
    return repr(name) if len(name) <= 80 else f"{name[:77]!r}…"
