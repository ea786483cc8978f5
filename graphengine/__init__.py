"""OmniGraph-style ActionGraphs in YAML, run against MuJoCo, seen by ROS 2."""

__version__ = "0.1.0"
