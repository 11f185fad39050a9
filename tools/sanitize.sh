#!/usr/bin/env bash
# tools/sanitize.sh asan+ubsan|tsan: builds that preset and runs its tests. The first runs the unit,
# gpu, analytic and statistical tests and bad input on the command line; the second the tests that
# reach every place where threads are started.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=$1
mkdir -p build
cmake --preset "$preset" >"build/$preset.log" 2>&1 || { cat "build/$preset.log" >&2; exit 3; }
cmake --build --preset "$preset"  # tsan's tests are run by their target
if [ "$preset" = tsan ]; then exit 0; fi
failed=0
ctest --preset "$preset" -j2 -L '^(unit|gpu|analytic|statistical)$' --no-tests=error || failed=1
ctest --preset "$preset" -R '^cli.test_(bad_input|hostile)$' --no-tests=error || failed=1
exit $failed
