// The program: its verbs, the options common to them, and what each kind of end means to the caller.
#pragma once

namespace anatomesh {

// Runs the command and gives its exit code: 0 done, 2 usage, 3 input, 4 geometry, 5 limit or memory, 6 file
// system, 7 internal, 130 cancelled.
int run_program(int argc, const char* const* argv);

}  // namespace anatomesh
