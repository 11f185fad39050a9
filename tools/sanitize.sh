#!/usr/bin/env bash
# tools/sanitize.sh asan+ubsan [long]|tsan: builds that preset and runs tests under it. asan+ubsan:
# all GoogleTest programs, and the command line with good and bad input; with `long`, which ./check
# leaves out, all other tests. tsan: those that start threads of ours. docs/robustness.md says what is
# left out and why.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=$1
mkdir -p build
cmake --preset "$preset" >"build/$preset.log" 2>&1 || { cat "build/$preset.log" >&2; exit 3; }
cmake --build --preset "$preset"
exec ctest --preset "$preset${2:+-$2}" -j2 --no-tests=error
