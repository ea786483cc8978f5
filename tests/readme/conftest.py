"""The fixture that runs a command in this process."""

from tests.cli.conftest import graphrun as graphrun
