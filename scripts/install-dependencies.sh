#!/bin/sh
# install-dependencies.sh [--check] GROUP...
# Installs the Debian packages that a group needs and that are missing. Groups: build, test, demo, bench, check, fuzz.
# Does nothing, at once, when all are there. With --check it only says what is missing (exit 1).
set -eu

# What compiles the program and what it needs to run.
build="g++ make cmake ninja-build libboost-dev libtbb-dev libdcmtk-dev libgdcm-dev
libinsighttoolkit5-dev zlib1g-dev libdeflate-dev libssl-dev libexpat1-dev nlohmann-json3-dev libfmt-dev libcli11-dev
libcpp-httplib-dev"
# What the tests need besides: the unit tests' framework, and libraries that judge our readers and writers.
test="libgtest-dev libcgal-dev libgmp-dev libmpfr-dev python3 python3-numpy python3-scipy python3-vtk9
python3-meshio python3-nibabel
python3-pydicom python3-jsonschema clang-format gmsh calculix-ccx locales dcmtk dicom3tools openssl
orthanc orthanc-dicomweb"
# The CT skull of the demonstration.
demo="invesalius-examples"
# What the benchmark runs beside the program, and what judges their models.
bench="libcgal-dev libgmp-dev libmpfr-dev tetgen gmsh python3-netgen libbenchmark-dev python3 python3-numpy python3-scipy
python3-vtk9 python3-nibabel"

# The second compiler and its sanitizers; libFuzzer.
lanes="clang libclang-rt-14-dev"
fuzz="$lanes"

check=no
wanted=
for argument in "$@"; do
    case $argument in
        --check) check=yes ;;
        build) wanted="$wanted $build" ;;
        test) wanted="$wanted $test" ;;
        demo) wanted="$wanted $demo" ;;
        bench) wanted="$wanted $bench" ;;
        check) wanted="$wanted $lanes" ;;
        fuzz) wanted="$wanted $fuzz" ;;
        *) echo "install-dependencies.sh: unknown group '$argument'; known: build, test, demo, bench, check, fuzz" >&2; exit 2 ;;
    esac
done

if ! command -v dpkg-query >/dev/null 2>&1; then
    # Not Debian: whoever builds here brings the libraries in another way; CMake says which one it does not find.
    [ $check = yes ] && exit 0
    echo "install-dependencies.sh: this script knows Debian 12 and its relatives only (no dpkg-query here)." >&2
    echo "Install these by your system's own means, then run cmake as CONTRIBUTING.md says:" $wanted >&2
    exit 1
fi

missing=
for package in $wanted; do
    state=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
    case " $missing " in *" $package "*) continue ;; esac
    [ "$state" = installed ] || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

if [ $check = yes ]; then
    echo "Missing Debian packages:$missing" >&2
    echo "Install them with: make dependencies" >&2
    exit 1
fi

sudo=
if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null 2>&1; then
        echo "install-dependencies.sh: neither root nor sudo; as root run:" >&2
        echo "  apt-get update && apt-get install --no-install-recommends$missing" >&2
        exit 1
    fi
    sudo="sudo"
fi
echo "Installing Debian packages:$missing"
$sudo apt-get update -q
$sudo env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends $missing

# The tests start an Orthanc of their own: the service that comes with the package is not to run because of them.
case " $missing " in
    *" orthanc "*)
        if command -v systemctl >/dev/null 2>&1; then $sudo systemctl disable --now orthanc.service || true; fi ;;
esac
