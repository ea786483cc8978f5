from __future__ import annotations

import sys
import tomllib
from contextlib import closing
from pathlib import Path

import pytest

from graphengine.format.errors import TransportError
from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions, Transport, TransportKind
from graphengine.ros.transports import select
from graphengine.ros.transports.select import open_transport, transport_helps
from tests.ros import needs


@pytest.fixture
def without_rclpy(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.partition(".")[0] == "rclpy"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(sys, "path", [path for path in sys.path if not (Path(path) / "rclpy").is_dir()])


@pytest.fixture
def domain(domain_id: int) -> Domain:
    return Domain(domain_id, "OFF")


def test_memory_joins_nothing(domain: Domain) -> None:
    assert open_transport("memory", JoinOptions(domain)).description == "memory: nothing leaves this process"


@pytest.mark.usefixtures("without_rclpy")
def test_without_rclpy_auto_chooses_dds_and_gives_the_reason(domain: Domain) -> None:
    with closing(open_transport("auto", JoinOptions(domain, "alice"))) as transport:
        assert transport.description.startswith(f"dds (Eclipse Cyclone DDS), domain {domain.id}, discovery range OFF; ")
        assert transport.description.endswith("chosen because rclpy cannot be used (no ROS 2 is sourced)")


@pytest.mark.usefixtures("without_rclpy")
def test_a_missing_rclpy_is_an_error_if_the_user_names_it(domain: Domain) -> None:
    with pytest.raises(TransportError, match=r"rclpy cannot be used: no ROS 2 is sourced\nsource a ROS 2 .*\.\[ros\]"):
        open_transport("rclpy", JoinOptions(domain))


def test_the_error_about_an_unknown_transport_lists_all_transports(domain: Domain) -> None:
    with pytest.raises(TransportError, match=r"no transport 'udp'\n.*dds, memory, rclpy"):
        open_transport("udp", JoinOptions(domain))


def test_a_checkout_without_metadata_has_all_transports(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(select, "entry_points", lambda group: ())
    monkeypatch.setattr(select, "_entries", select._entries.__wrapped__)  # without its cache
    assert list(transport_helps()) == ["auto", "rclpy", "dds", "memory"]
    assert list(transport_helps(reaching_others=True)) == ["auto", "rclpy", "dds"]


def test_the_project_file_registers_all_transports_of_the_package() -> None:
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())["project"]
    registered = project["entry-points"][select.GROUP]
    found = {name: entry.value for name, (entry, *_) in select._entries().items()}
    assert registered == {name: found[name] for name in registered}
    assert set(registered) == {"dds", "memory", "rclpy"}


@pytest.mark.parametrize(
    ("name", "reason"), [("dds", "dds cannot be used: {}"), ("auto", r"; dds cannot be used \({}\)")]
)
@pytest.mark.usefixtures("without_rclpy")
def test_without_cyclonedds_the_error_has_one_reason_and_a_remedy(
    domain: Domain, monkeypatch: pytest.MonkeyPatch, name: str, reason: str
) -> None:
    monkeypatch.setitem(sys.modules, "cyclonedds", None)
    why = reason.format("import of cyclonedds halted; None in sys.modules")
    with pytest.raises(TransportError, match=rf"{why}\n(.*\n)?PyPI has cyclonedds for [^$]*--transport memory"):
        open_transport(name, JoinOptions(domain))


def test_an_unexpected_exception_while_joining_is_an_error_of_one_line(
    domain: Domain, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(options: JoinOptions) -> Transport:
        raise OSError("no antenna\nat all")

    monkeypatch.setattr(select, "find_transport", lambda name: TransportKind(name, "a radio", fail))
    with pytest.raises(TransportError, match=r"transport 'radio' cannot join domain \d+: OSError: no antenna\Z"):
        open_transport("radio", JoinOptions(domain))


@pytest.mark.ros(needs.sourced())
def test_with_rclpy_auto_chooses_rclpy_and_gives_the_reason(domain_id: int) -> None:
    with closing(open_transport("auto", JoinOptions(Domain(domain_id, "LOCALHOST"), "alice"))) as transport:
        assert transport.description.startswith("rclpy (rmw_")
        assert transport.description.endswith("chosen because rclpy is installed")


def test_the_description_of_dds_warns_about_unreachable_zenoh_peers(domain: Domain) -> None:
    with closing(
        open_transport("dds", JoinOptions(domain, environ={"RMW_IMPLEMENTATION": "rmw_zenoh_cpp"}))
    ) as transport:
        assert "RMW_IMPLEMENTATION is rmw_zenoh_cpp, whose peers" in transport.description
    with closing(
        open_transport("dds", JoinOptions(domain, environ={"RMW_IMPLEMENTATION": "rmw_fastrtps_cpp"}))
    ) as transport:
        assert "RMW" not in transport.description
