// anatomesh: tetrahedral models of anatomy from contours on medical image slices.
#include "program.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

int main(int argc, char** argv) {
#ifdef __GLIBC__
    // What one stage frees the next one uses again; pages given back and asked for anew would have to be
    // cleared.
    mallopt(M_MMAP_THRESHOLD, 1 << 30);
    mallopt(M_TRIM_THRESHOLD, -1);
#endif
    return anatomesh::run_program(argc, argv);
}
