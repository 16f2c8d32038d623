#include "field_options.h"

#include <fmt/format.h>

#include <optional>
#include <string>

#include "anatomesh/field/end_caps.h"
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
    add_slice_thickness_option(verb, options.single_slice_mm);
    group_new_options(verb, option_group::slices);
}

void add_slice_thickness_option(CLI::App& verb, double& slice_mm) {
    add_number(verb, "--slice-thickness", slice_mm, 0.001, 1000, "MM",
               "Thickness of a single slice, 0.001 to 1000 mm. It is needed if there is one slice only.");
}

Status check_slice_thickness(double slice_mm, const std::string& input, const ContourSet& kept) {
    if (slice_mm == 0 || kept.slices.size() < 2) return Nothing{};
    return Error{ErrorKind::usage,
                 "E-CMD-008",
                 fmt::format("--slice-thickness does not apply to {} slices; it is for a single slice",
                             kept.slices.size()),
                 {input, "", "", "", ""},
                 "leave out --slice-thickness"};
}

}  // namespace anatomesh
