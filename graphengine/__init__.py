"""OmniGraph-style ActionGraphs in YAML, run against MuJoCo, seen by ROS 2."""

from graphengine.format.version import __version__ as __version__
