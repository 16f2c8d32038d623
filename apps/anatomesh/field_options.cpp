#include "field_options.h"

#include <fmt/format.h>

#include <optional>
#include <string>

#include "anatomesh/field/end_caps.h"
#include "anatomesh/slices/arrangement/slice_arrangement.h"
#include "anatomesh/slices/coverage/few_slices.h"
#include "help_text.h"
#include "option_values.h"

namespace anatomesh {

void add_field_rule_options(CLI::App& verb, FieldOptions& options) {
    const auto read_caps = [&options](const std::string& text) {
        const std::optional<EndCaps> caps = end_caps_of(text);
        if (!caps)
            throw CLI::ValidationError("--caps", fmt::format("'{}' is not one of half, flat, rounded", text));
        options.caps = *caps;
    };
    verb.add_option_function<std::string>("--caps", read_caps,
                                          "How a structure ends beyond its last slice: half a slice further "
                                          "(half), at the slice (flat), or half a "
                                          "slice further with a rounded rim (rounded). Default: half.")
        ->type_name("half|flat|rounded");
    add_number(verb, "--max-gap", options.max_gap_spacings, 1, 1e6, "SPACINGS",
               fmt::format("Join a structure over missing slices if the gap is at most this many slice "
                           "spacings, 1 to 1000000. "
                           "Default: {}.",
                           options.max_gap_spacings));
    add_slice_thickness_option(verb, options.single_slice_mm,
                               "Thickness of the slices of structures that are drawn on one or two slices "
                               "alone. It is needed where there is "
                               "one slice in all and nothing states it");
    group_new_options(verb, option_group::slices);
}

void add_slice_thickness_option(CLI::App& verb, double& slice_mm, const std::string& of_what) {
    add_number(verb, "--slice-thickness", slice_mm, 0.001, 1000, "MM", of_what + ", 0.001 to 1000 mm.");
}

Error slice_thickness_without_use(const std::string& input, const std::string& why) {
    return {ErrorKind::usage,
            "E-CMD-008",
            "--slice-thickness does not apply, because " + why,
            {input, "", "", "", ""},
            "leave out --slice-thickness"};
}

Status check_slice_thickness(double slice_mm, const std::string& input, const ContourSet& kept) {
    if (slice_mm == 0 || kept.slices.size() < 2) return Nothing{};
    if (!arrangement_of(kept).is_stack())
        return slice_thickness_without_use(
            input, "the slices are no stack, and those that cross show the thickness");
    if (!structures_on_few_slices(kept).empty()) return Nothing{};
    return slice_thickness_without_use(
        input, says_all(kept)
                   ? "the slices say all of every structure, so that they end it where it is absent"
                   : "every structure is drawn on three slices or more, which show it");
}

}  // namespace anatomesh
