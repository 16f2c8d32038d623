#include "anatomesh/outliers/warn_about_outlying_slices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "anatomesh/base/number_text.h"
#include "anatomesh/base/plural.h"
#include "anatomesh/contour/model/chosen_slices.h"
#include "anatomesh/outliers/outlying_slices.h"
#include "anatomesh/outliers/shape_of_structure.h"

namespace anatomesh {

namespace {

// So many slices have a warning of their own; of the others the names are enough. [slices; >= 1; B]
constexpr std::size_t most_told = 5;

constexpr double mm3_per_cm3 = 1000;  // [mm3; 1000; D]

// As a shell takes it for one word.
std::string one_word(const std::string& name) {
    const auto is_plain = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               std::string_view("-_./:=,+%@").find(c) != std::string_view::npos;
    };
    if (!name.empty() && std::all_of(name.begin(), name.end(), is_plain)) return name;
    std::string word = "'";
    for (const char c : name) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return word + "'";
}

// To tenths; rounding leaves no negative zero.
std::string tenths(double value) {
    return fixed_text(std::round(10 * value) / 10 + 0.0, 1);
}

std::string place_text(Vec3 p) {
    return "at (" + tenths(p.x) + ", " + tenths(p.y) + ", " + tenths(p.z) + ") mm";
}

std::string what_is_wrong(const OutlyingSlice& outlier) {
    switch (outlier.kind) {
        case OutlierKind::displaced:
            return "the contours of the slice are displaced from the line between the slices before and "
                   "after, which agree "
                   "without it";
        case OutlierKind::larger:
            return "the contours of the slice reach farther out than those of the slices before and after, "
                   "which agree "
                   "without it";
        case OutlierKind::smaller:
            return "the contours of the slice leave out what the slices before and after both have";
        case OutlierKind::other_shape:
            return "the contours of the slice have another shape than those of the slices before and after, "
                   "which agree "
                   "without it";
        case OutlierKind::part_missing:
            return "the slice does not show a part that the slices before and after both show";
        case OutlierKind::part_alone:
            return "the slice shows a part that lies far from all that the slices before and after show";
        case OutlierKind::part_displaced:
            return "the slice shows a part elsewhere than the slices before and after";
        case OutlierKind::hole_missing:
            return "the slice does not show a hole that the slices before and after both show";
        case OutlierKind::hole_alone:
            return "the slice shows a hole where the slices before and after are solid";
        case OutlierKind::hole_displaced:
            break;
    }
    return "the slice shows a hole elsewhere than the slices before and after";
}

// How far, then how much.
std::string size_text(const OutlyingSlice& outlier) {
    std::string distance = brief(outlier.distance_mm) + " mm";
    switch (outlier.kind) {
        case OutlierKind::displaced:
            break;
        case OutlierKind::larger:
        case OutlierKind::smaller:
        case OutlierKind::other_shape:
            distance += " in the mean";
            break;
        case OutlierKind::part_alone:
            distance += " from the nearest part";
            break;
        case OutlierKind::part_missing:
        case OutlierKind::part_displaced:
        case OutlierKind::hole_missing:
        case OutlierKind::hole_alone:
        case OutlierKind::hole_displaced:
            distance += " wide";
            break;
    }
    if (outlier.kind == OutlierKind::displaced) return distance;
    return distance + ", " + brief(outlier.area_mm2) + " mm2, " + percent_text(outlier.share, 1, 0) +
           " of what is drawn there";
}

std::string volume_text(double volume_mm3) {
    return volume_mm3 < mm3_per_cm3 ? brief(volume_mm3) + " mm3" : brief(volume_mm3 / mm3_per_cm3) + " cm3";
}

std::string shape_text(const StructureShape& shape) {
    std::string text = volume_text(shape.volume_mm3);
    if (!shape.is_counted) return text;
    text += " in " + counted(shape.parts, "part");
    if (shape.tunnels > 0) text += " with " + counted(shape.tunnels, "tunnel");
    if (shape.cavities > 0)
        text += (shape.tunnels > 0 ? " and " : " with ") + counted(shape.cavities, "cavity", "cavities");
    return text;
}

// Empty where the field cannot be made of one of the two.
std::string without_text(const ContourSet& set, const OutlyingSlice& outlier, const FieldOptions& options,
                         const RunContext& context) {
    const std::array names{set.slices[outlier.slice].name};
    const Result<ContourSet> others = without_slices(set, names);
    if (!others.ok()) return "";
    const Result<StructureShape> with = shape_of_structure(set, outlier.structure, options, context);
    const Result<StructureShape> without =
        shape_of_structure(others.value(), outlier.structure, options, context);
    if (!with.ok() || !without.ok()) return "";
    return "; with the slice the structure has about " + shape_text(with.value()) + ", without it " +
           shape_text(without.value());
}

// How many structures a slice draws.
std::size_t structures_on(const ContourSet& set, const Slice& slice) {
    std::size_t count = 0;
    const Contour* before = nullptr;
    for (const Contour& contour : set.contours_of(slice)) {
        count += before == nullptr || before->structure != contour.structure;
        before = &contour;
    }
    return count;
}

bool is_told(const std::string& slice, const RunContext& context) {
    return std::any_of(context.warnings.begin(), context.warnings.end(), [&](const Warning& told) {
        return told.code.starts_with("W-RCN") && told.place.slice == slice;
    });
}

}  // namespace

void warn_about_outlying_slices(const ContourSet& set, const SliceArrangement& arrangement,
                                const FieldOptions& options, RunContext& context) {
    if (!set.drawn || set.contours.empty()) return;
    std::vector<OutlyingSlice> outliers = find_outlying_slices(set, arrangement, context);
    std::erase_if(outliers,
                  [&](const OutlyingSlice& o) { return is_told(set.slices[o.slice].name, context); });
    std::stable_sort(outliers.begin(), outliers.end(),
                     [](const OutlyingSlice& a, const OutlyingSlice& b) { return a.share > b.share; });
    std::string others;
    for (std::size_t n = most_told; n < outliers.size(); ++n)
        others += (n > most_told ? ", " : "") + set.slices[outliers[n].slice].name;
    if (outliers.size() > most_told) outliers.resize(most_told);
    for (const OutlyingSlice& outlier : outliers) {
        const Structure& structure = set.structures[outlier.structure];
        const std::string& slice = set.slices[outlier.slice].name;
        const std::size_t drawn = structures_on(set, set.slices[outlier.slice]);
        const bool is_last = &outlier == &outliers.back();
        context.warn(
            {outlier.kind == OutlierKind::displaced ? "W-FLD-011" : "W-FLD-020",
             what_is_wrong(outlier) + ", " + place_text(outlier.where),
             {set.source, slice, structure.name.empty() ? std::to_string(structure.number) : structure.name,
              "", size_text(outlier)},
             "kept as drawn" + without_text(set, outlier, options, context) +
                 "; look at the slice; --without " + one_word(slice) + " leaves it out" +
                 (drawn > 1 ? ", for all " + std::to_string(drawn) + " structures that it draws" : "") +
                 (is_last && !others.empty() ? "; these slices differ less: " + others : "")});
    }
}

}  // namespace anatomesh
