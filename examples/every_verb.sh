#!/bin/sh
# Every verb on two structures drawn on six slices: examples/every_verb.sh [FOLDER]. The results go into FOLDER
# (default: organ_and_tumour). ANATOMESH names the program (default: the one on the path).
set -eu
here=$(cd "$(dirname "$0")" && pwd)
program=${ANATOMESH:-anatomesh}
folder=${1:-organ_and_tumour}
mkdir -p "$folder"

# What is in the file?
"$program" info "$here/organ_and_tumour.json"

# A model of both structures, which overlap (a warning says how much), with its surface, its contours and a page to look at.
"$program" model "$here/organ_and_tumour.json" -o "$folder/both.vtu" --surface "$folder/both.stl" \
    --contours "$folder/both.contours.json" --html "$folder/both.html"

# Is it right? Exit code 4 when it is not.
"$program" check "$folder/both.vtu" --contours "$folder/both.contours.json"

# One of the two alone, finer, for a finite-element program.
"$program" model "$here/organ_and_tumour.json" --structure tumour --size 1.5 -o "$folder/tumour.inp"

# Contours for other programs: polylines that ParaView shows.
"$program" contours "$here/organ_and_tumour.json" -o "$folder/contours.vtp" --report "$folder/contours.report.json"

# The same model for Gmsh, and how far its surface is from the first one's: not at all.
"$program" convert "$folder/both.vtu" -o "$folder/both.msh"
"$program" compare "$folder/both.vtu" "$folder/both.msh"
