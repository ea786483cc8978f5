#!/bin/sh
# The tests of the network with the ROS 2 that is sourced, on each of the two RMWs over DDS that it has.
set -eu
cd "$(dirname "$0")/.."
# With the system's packages: those of ROS are built for its numpy, and Python packages of ROS come from it.
"${PYTHON:-python3}" -m venv --system-site-packages .venv-ros
.venv-ros/bin/pip install --quiet --disable-pip-version-check --editable '.[test]'
failed=0
for rmw in ${RMW_IMPLEMENTATION:-rmw_fastrtps_cpp rmw_cyclonedds_cpp}; do
    # ROS brings plugins for pytest that are of no use here, and do not fit each version of it.
    RMW_IMPLEMENTATION=$rmw PYTEST_DISABLE_PLUGIN_AUTOLOAD=1 .venv-ros/bin/python -m pytest -p pytest_timeout tests/ros "$@" || failed=1
done
exit $failed
