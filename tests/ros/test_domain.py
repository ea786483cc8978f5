from __future__ import annotations

import pytest

from graphengine.format.errors import TransportError
from graphengine.ros.domain import Domain


def test_an_empty_environment_means_domain_0_and_the_subnet() -> None:
    assert Domain.from_environment({}) == Domain(0, "SUBNET", (), "")
    assert Domain.from_environment({"ROS_DOMAIN_ID": "", "ROS_AUTOMATIC_DISCOVERY_RANGE": ""}) == Domain()


def test_all_discovery_variables_of_ros_2_are_read() -> None:
    environ = {"ROS_DOMAIN_ID": "42", "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    environ |= {"ROS_STATIC_PEERS": "10.0.0.7;robot.local;", "CYCLONEDDS_URI": "<CycloneDDS/>"}
    assert Domain.from_environment(environ) == Domain(42, "LOCALHOST", ("10.0.0.7", "robot.local"), "<CycloneDDS/>")
    assert Domain.from_environment({"ROS_DOMAIN_ID": "0x10"}).id == 16
    assert str(Domain.from_environment(environ)) == "domain 42, discovery range LOCALHOST, with CYCLONEDDS_URI"


def test_localhost_only_overrules_range_and_peers() -> None:
    environ = {"ROS_LOCALHOST_ONLY": "1", "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "ROS_STATIC_PEERS": "10.0.0.7"}
    assert Domain.from_environment(environ) == Domain(0, "LOCALHOST")
    assert Domain.from_environment({"ROS_LOCALHOST_ONLY": "0"}) == Domain()


@pytest.mark.parametrize(
    ("name", "value", "legal"),
    [
        ("ROS_DOMAIN_ID", "one", "0 to 232"),
        ("ROS_DOMAIN_ID", "-1", "0 to 232"),
        ("ROS_DOMAIN_ID", "233", "0 to 232"),
        ("ROS_DOMAIN_ID", "1.5", "0 to 232"),
        ("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHSOT", "did you mean 'LOCALHOST'?"),
        ("ROS_AUTOMATIC_DISCOVERY_RANGE", "NOT_SET", "legal: SUBNET, LOCALHOST, OFF, SYSTEM_DEFAULT"),
        ("ROS_LOCALHOST_ONLY", "true", "legal: 0, 1"),
    ],
)
def test_the_error_about_an_illegal_value_lists_the_legal_values(name: str, value: str, legal: str) -> None:
    with pytest.raises(TransportError) as caught:
        Domain.from_environment({name: value})
    assert name in str(caught.value)
    assert repr(value) in str(caught.value)
    assert legal in str(caught.value)


def test_an_illegal_domain_id_is_refused() -> None:
    with pytest.raises(TransportError, match="domain id 233 is out of range; legal: 0 to 232"):
        Domain(233)
