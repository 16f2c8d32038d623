#!/bin/sh
# check.sh JOBS: the unit tests once more with clang, with the address and undefined-behaviour sanitizers, and with the
# thread sanitizer, each in a build of its own. An hour or so: for a release, and for changes to memory or threads.
set -eu
jobs=$1
for lane in clang asan tsan; do
    echo "== $lane"
    cmake --preset "$lane" -DANATOMESH_TESTS=ON
    cmake --build --preset "$lane" --parallel "$jobs"
    ctest --preset "$lane" --parallel "$jobs" --no-tests=error </dev/null
done
