// The verbs: each file <verb>.cpp adds its options to the command line and gives back the work to do.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

#include "anatomesh/base/result.h"
#include "session.h"

namespace anatomesh {

// What a verb does once its options are read. Returns when the work is done; an Error ends the program with
// its exit code.
using Work = std::function<Status(Session&)>;

// Each adds its options to `verb`, which outlives the Work. Options common to all verbs (--json, --quiet,
// --threads) are the program's.
Work declare_info(CLI::App& verb);
Work declare_segment(CLI::App& verb);
Work declare_contours(CLI::App& verb);
Work declare_field(CLI::App& verb);
Work declare_model(CLI::App& verb);
Work declare_check(CLI::App& verb);
Work declare_compare(CLI::App& verb);
Work declare_convert(CLI::App& verb);
Work declare_project(CLI::App& verb);
Work declare_receive(CLI::App& verb);
Work declare_query(CLI::App& verb);
Work declare_fetch(CLI::App& verb);
Work declare_send(CLI::App& verb);
Work declare_where_next(CLI::App& verb);

}  // namespace anatomesh
