#!/bin/sh
# demo.sh PROGRAM: models the CT skull of Debian's package invesalius-examples into demo/.
set -eu
program=$1
skull=$(scripts/skull.sh)
mkdir -p demo
"$program" model "$skull" --threshold 226 --keep-largest 1 --every 2 -o demo/skull.vtu \
    --surface demo/skull.stl --surface demo/skull.vtp --contours demo/skull_contours.vtp \
    --report demo/report.json --html demo/report.html
"$program" check demo/skull.vtu --contours demo/skull_contours.vtp
cat <<EOF

The skull is in $(pwd)/demo:
  report.html          open it in a browser: the surface in 3D, a cut through the tetrahedra, counts, times, quality
  report.json          the same figures for programs
  skull.vtu            the tetrahedra (ParaView, meshio, VTK)
  skull.stl, .vtp      its surface
  skull_contours.vtp   the contours it was made from
EOF
