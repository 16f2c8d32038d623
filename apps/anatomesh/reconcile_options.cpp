#include "reconcile_options.h"

#include <fmt/format.h>

#include <string>

#include "help_text.h"
#include "option_values.h"

namespace anatomesh {

void add_reconcile_options(CLI::App& verb, InputOptions& options) {
    ReconcileOptions& reconcile = options.prepare.reconcile;
    add_number(
        verb, "--max-disagreement", reconcile.max_disagreement_mm, 0.001, 1000, "MM",
        fmt::format(
            "Largest distance by which a contour may move so that crossing slices agree, 0.001 to 1000 mm. "
            "Slices that disagree by more are refused. Default: {}.",
            reconcile.max_disagreement_mm));
    const auto read_choice = [&reconcile](const std::string& text) {
        if (text != "0" && text != "1")
            throw CLI::ValidationError("--reconcile", fmt::format("'{}' is not one of 0, 1", text));
        reconcile.reconcile = text == "1";
    };
    verb.add_option_function<std::string>("--reconcile", read_choice,
                                          "1 moves contours so that crossing slices agree, and lets contours "
                                          "follow the edges of the model. 0 keeps "
                                          "contours as drawn. Default: 1.")
        ->type_name("0|1");
    verb.add_flag(
        "--align", reconcile.align,
        "First shift every slice within its plane to where it agrees best with the slices that it crosses.");
    for (const char* name : {"--max-disagreement", "--reconcile", "--align"}) {
        verb.get_option(name)->each(
            [&options, name](const std::string&) { options.reconcile_given.push_back(name); });
    }
    group_new_options(verb, option_group::crossing_planes);
}

Status check_reconcile_options(const ContourSet& kept, const InputOptions& options) {
    if (options.reconcile_given.empty() || !all_parallel(kept, parallel_tolerance_mm)) return Nothing{};
    const std::string& option = options.reconcile_given.front();
    return Error{ErrorKind::usage,
                 "E-CMD-008",
                 option + " does not apply: the slices are parallel and do not cross",
                 {kept.source, "", "", "", ""},
                 "leave out " + option};
}

}  // namespace anatomesh
