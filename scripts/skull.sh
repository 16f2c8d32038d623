#!/bin/sh
# skull.sh: prints the path of the CT skull Cranium.inv3 of Debian's package invesalius-examples.
# Systems that leave out /usr/share/doc (slim container images) have the package without the file: then the
# package is fetched again and unpacked under build/.
set -eu
cd "$(dirname "$0")/.."
unpacked=build/invesalius-examples
for folder in /usr/share/doc/invesalius-examples/examples $unpacked/usr/share/doc/invesalius-examples/examples; do
    if [ -r "$folder/Cranium.inv3" ]; then echo "$folder/Cranium.inv3"; exit 0; fi
done
mkdir -p build
(cd build && apt-get download -q invesalius-examples >&2)
dpkg -x build/invesalius-examples_*.deb $unpacked
rm -f build/invesalius-examples_*.deb
echo "$unpacked/usr/share/doc/invesalius-examples/examples/Cranium.inv3"
