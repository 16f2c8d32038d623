#include "reconcile_options.h"

#include <fmt/format.h>

#include <string>

#include "option_values.h"

namespace anatomesh {

void add_reconcile_options(CLI::App& verb, InputOptions& options) {
    ReconcileOptions& reconcile = options.prepare.reconcile;
    add_number(verb, "--max-disagreement", reconcile.max_disagreement_mm, 0.001, 1000, "MM",
               fmt::format("Move contours of slices that cross by up to MM, so that they agree (where more "
                           "than two meet in a "
                           "line, with most of them), 0.001 to 1000; slices further apart, in the median of "
                           "their region ends or in what would have to move, are refused; nor do contours "
                           "go further to follow the surface where no edges of it run along them "
                           "(default {})",
                           reconcile.max_disagreement_mm));
    const auto read_choice = [&reconcile](const std::string& text) {
        if (text != "0" && text != "1")
            throw CLI::ValidationError("--reconcile", fmt::format("'{}' is not one of 0, 1", text));
        reconcile.reconcile = text == "1";
    };
    verb.add_option_function<std::string>(
            "--reconcile", read_choice,
            "Whether contours of slices that cross are made to agree, and follow the surface where no "
            "edges of it run along them (1, default), or are kept as drawn (0)")
        ->type_name("0|1");
    verb.add_flag("--align", reconcile.align,
                  "First shift every slice in its plane so that it agrees best with those that it crosses");
    for (const char* name : {"--max-disagreement", "--reconcile", "--align"}) {
        verb.get_option(name)->each(
            [&options, name](const std::string&) { options.reconcile_given.push_back(name); });
    }
}

Status check_reconcile_options(const ContourSet& kept, const InputOptions& options) {
    if (options.reconcile_given.empty() || !all_parallel(kept, parallel_tolerance_mm)) return Nothing{};
    const std::string& option = options.reconcile_given.front();
    return Error{ErrorKind::usage,
                 "E-CMD-008",
                 option + " does not apply: the slices are parallel, so that none cross",
                 {kept.source, "", "", "", ""},
                 "leave out " + option};
}

}  // namespace anatomesh
