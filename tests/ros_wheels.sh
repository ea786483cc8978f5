#!/bin/sh
# The tests against rclpy of the wheels on PyPI, on Fast DDS. The wheels get an environment of their own, as they start each
# Python process twice; all other packages come from the environment that tests/all.sh made for the same Python.
set -eu
cd "$(dirname "$0")/.."
python=${PYTHON:-python3}
version=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
venv=.venv-wheels-$version
unset RMW_IMPLEMENTATION
"$python" -m venv "$venv"
echo "$PWD/.venv-$version/lib/python$version/site-packages" > "$venv/lib/python$version/site-packages/packages_of_tests.pth"
install="$venv/bin/python -m pip install --quiet --disable-pip-version-check"
if ! $install --editable '.[ros]' ros-jazzy-test-msgs==2.0.3; then
    echo "no tests against rclpy: the wheels of ROS 2 do not install here"
    exit 0
fi
"$venv/bin/python" -m pip check
if ! "$venv/bin/python" -c 'from graphengine.ros.transports import rcl; raise SystemExit(rcl.missing())'; then
    echo "no tests against rclpy: it cannot be used here"
    exit 0
fi
processors=$("$python" -c 'import os; print(len(getattr(os, "sched_getaffinity", lambda _: range(os.cpu_count()))(0)))')
others=$(grep -rlE 'pytest\.mark\.ros\b' tests --include='test_*.py' | grep -v '^tests/ros/')
# shellcheck disable=SC2086  # file names without spaces
"$venv/bin/python" -m pytest -p tests.ros.needs -m ros -n "$((processors + 1))" --dist loadfile -rfE "$@" tests/ros $others
