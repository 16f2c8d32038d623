#!/bin/sh
# test.sh BUILD JOBS: builds everything and runs every test. Ends with the line "N passed, N failed", counted from
# ctest's own results, and fails when a test failed or none ran.
set -eu
build=$1
jobs=$2
cmake --preset release -DANATOMESH_TESTS=ON
cmake --build "$build" --parallel "$jobs"
status=0
ctest --test-dir "$build" --parallel "$jobs" --output-on-failure --output-junit test-results.xml \
      --no-tests=error </dev/null || status=$?
/usr/bin/python3 scripts/count_tests.py "$build/test-results.xml" "$status"
