#!/bin/sh
# Everything that must hold, on one Python: style, types, layers, tests. Makes its own environment in .venv-<version>.
# With TESTS_ONLY=1 the tests alone: style, types and layers are the same on every Python.
set -eu
cd "$(dirname "$0")/.."
python=${PYTHON:-python3}
venv=.venv-$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
[ -x "$venv/bin/pip" ] || rm -rf "$venv"  # of a run that was interrupted
"$python" -m venv "$venv"
# With uv, where it is on the path, in a fraction of pip's time.
if ! { command -v uv >/dev/null && uv pip install --quiet --python "$venv/bin/python" --editable '.[test]'; }; then
    "$venv/bin/pip" install --quiet --disable-pip-version-check --no-compile --editable '.[test]'
fi
"$venv/bin/python" -m compileall -q -q -j 0 "$venv/lib" || true  # on all processors; some templates are no Python
PATH="$PWD/$venv/bin:$PATH"
export PATH
processors=$(python -c 'import os; print(len(getattr(os, "sched_getaffinity", lambda _: range(os.cpu_count()))(0)))')
if [ -z "${TESTS_ONLY:-}" ]; then
    sources="graphengine nodes examples ros tests"  # not what a user keeps beside them
    # shellcheck disable=SC2086
    ruff check $sources && ruff format --check --quiet $sources
    mypy --num-workers "$processors"
    lint-imports --no-cache
fi
# Compiled once, and kept: no test waits for it, or hears that it takes some seconds.
python -c 'from graphengine.physics.ray_casting.fast import rays; rays.trouble()'
# One process more than there are processors, as many tests wait for another process.
python -m pytest -n "$((processors + 1))" --dist loadfile "$@"
