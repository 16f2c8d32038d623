#!/bin/sh
# fuzz.sh BUILD SECONDS JOBS [TARGET...]: fuzzes each target (all without) for so many seconds. What is found lies
# in BUILD/found/TARGET; a file that was mended belongs into tests/fuzz/found/TARGET, where the tests replay it.
set -eu
build=$1
seconds=$2
jobs=$3
shift 3
targets=${*:-dicom_series rtstruct seg nifti nrrd metaimage contour_json csl inv3}
cmake --preset fuzz >/dev/null
for target in $targets; do programs="${programs:-} fuzz_$target"; done
cmake --build "$build" --parallel "$jobs" --target fuzz_replay $programs
status=0
for target in $targets; do
    corpus=$build/corpus/$target
    found=$build/found/$target
    mkdir -p "$corpus" "$found"
    "$build/tests/fuzz/fuzz_replay" --write "$target" "$corpus"
    [ ! -d "tests/fuzz/found/$target" ] || cp "tests/fuzz/found/$target/"* "$corpus"
    echo "== $target"
    "$build/tests/fuzz/fuzz_$target" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=1024 -max_len=65536 \
        -artifact_prefix="$found/" -print_final_stats=1 -verbosity=0 "$corpus" || status=1
done
exit $status
