#!/bin/sh
# The steps of a release, each of which .github/workflows/release.yml runs on clean machines. In this order:
#
#   sh tests/release.sh build            write dist/*.tar.gz, and build dist/*.whl from it
#   sh tests/release.sh check [TAG]      check the contents and descriptions of both, and that TAG is v and their version
#   sh tests/release.sh install          install the wheel in a new environment, and run the demo there
#   sh tests/release.sh tests [...]      unpack dist/*.tar.gz and run its tests; takes pytest's arguments
#
# PYTHON=python3.12 selects the Python. TRANSPORT=memory stands for a machine that cannot install Cyclone DDS: the demo runs in
# memory, and the tests are those that need neither Cyclone DDS nor Linux's own borders.
set -eu
cd "$(dirname "$0")/.."
python=${PYTHON:-python3}
transport=${TRANSPORT:-dds}
everywhere="tests/compiler tests/devices tests/drawing tests/format tests/messages tests/node tests/nodes tests/runtime"
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

environment() {  # a new environment with the given packages
    "$python" -m venv "$scratch/venv"
    "$scratch/venv/bin/pip" install --quiet --disable-pip-version-check "$@"
}

case ${1:-} in
build)
    rm -f dist/graphrun-*
    environment build
    "$scratch/venv/bin/python" -m build --outdir dist .
    ;;
check)
    environment check-wheel-contents twine
    "$scratch/venv/bin/twine" check --strict dist/graphrun-*
    "$scratch/venv/bin/check-wheel-contents" dist/graphrun-*.whl
    "$scratch/venv/bin/python" tests/release_contents.py dist "${2:-}"
    ;;
install)
    environment "$(ls "$PWD"/dist/graphrun-*.whl)[view]"
    cd "$scratch"
    venv/bin/graphrun --version --verbose
    venv/bin/graphrun check dd100_warehouse
    venv/bin/graphrun demo --for 5s --transport "$transport"
    venv/bin/pip check --disable-pip-version-check
    ;;
tests)
    shift
    tar -xzf dist/graphrun-*.tar.gz -C "$scratch"
    cd "$scratch"/graphrun-*
    if [ "$transport" = memory ] || [ "$(uname -s)" != Linux ]; then
        # shellcheck disable=SC2086  # folders without spaces
        set -- $everywhere "$@"
    fi
    PYTHON=$python TESTS_ONLY=1 sh tests/all.sh "$@"
    ;;
*)
    sed -n '2,/^set/s/^# \{0,1\}//p' "$0"
    exit 2
    ;;
esac
