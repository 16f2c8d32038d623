// anatomesh: tetrahedral models of anatomy from contours on medical image slices.
#include "program.h"

int main(int argc, char** argv) {
    return anatomesh::run_program(argc, argv);
}
