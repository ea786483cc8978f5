"""The registry of devices: what nodes may ask for, and what stands in where there is no physics."""

from __future__ import annotations

import pytest

from graphengine.devices.contact import ContactReading, ContactSensor, ContactSensorStub
from graphengine.devices.device import device_of
from graphengine.devices.dry_world import DryWorld
from graphengine.devices.stage import Stage
from graphengine.format.kinds import DEVICES, Kinds
from graphengine.format.stateful import Shared
from graphengine.physics.implementations import IMPLEMENTATIONS


def test_every_kind_has_an_implementation_and_a_stub_that_checkpoints_do_not_copy() -> None:
    assert list(IMPLEMENTATIONS.all) == sorted(DEVICES.all)
    assert all(issubclass(device.stub, Shared) for device in DEVICES.all.values())


def test_a_protocol_its_stub_and_its_implementation_have_the_same_kind() -> None:
    classes = (ContactSensor, ContactSensorStub, IMPLEMENTATIONS.all["contact"].handle)
    assert {device_of(cls).kind for cls in classes} == {"contact"}


def test_device_of_refuses_a_class_that_is_not_a_device() -> None:
    with pytest.raises(
        TypeError, match=r"Stage'> is not a device; pass a Protocol that a module of graphengine\.devices"
    ):
        device_of(Stage)


def test_two_modules_cannot_define_one_kind() -> None:
    kinds = Kinds[int]("graphengine.devices")
    kinds.add("contact", 1)
    with pytest.raises(ValueError, match=r"two modules of graphengine\.devices define 'contact'"):
        kinds.add("contact", 2)


def test_nodes_get_the_same_stub_that_a_test_writes_to() -> None:
    world = DryWorld(Stage())
    prim = world.stage.add("/bumper", "contact")
    sensor = world.device(ContactSensor, prim)
    world.device(ContactSensorStub, prim).felt = ContactReading(0.5, True, 3.0)
    assert sensor.reading().force == 3.0
