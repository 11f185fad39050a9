#!/usr/bin/env bash
# tools/fuzz.sh SECONDS: builds the fuzzers and runs each on its seeds and then SECONDS long on new
# inputs. What fails is left in build/fuzz/found; new inputs worth keeping stay in build/fuzz/corpus.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=$1
mkdir -p build
cmake --preset fuzz >build/fuzz.log 2>&1 || { cat build/fuzz.log >&2; exit 3; }
cmake --build --preset fuzz

# Leaks are looked for at the end of each input; nothing may take more than 2 GB or 20 s.
options=(-rss_limit_mb=2048 -timeout=20 -max_len=16384 -print_final_stats=1)
failed=0
for target in gltf probe cell experiment measurements history; do
  corpus=build/fuzz/corpus/$target
  found=build/fuzz/found/$target
  log=build/fuzz/$target.log
  mkdir -p "$corpus" "$found"
  more=()
  if [ -e tests/fuzz/$target.dict ]; then more=(-dict=tests/fuzz/$target.dict); fi
  program=build/fuzz/tests/fuzz/fuzz_$target
  if "$program" "${options[@]}" -runs=0 tests/fuzz/seeds/$target >"$log" 2>&1 &&
    "$program" "${options[@]}" "${more[@]}" -artifact_prefix="$found/" \
      -max_total_time="$seconds" "$corpus" tests/fuzz/seeds/$target >"$log" 2>&1; then
    echo "fuzz_$target: $(sed -n 's/^stat::number_of_executed_units: *//p' "$log") inputs, none failed"
  else
    echo "fuzz_$target: FAILED; see $log and $found"
    tail -n 40 "$log"
    failed=1
  fi
done
exit $failed
