#include "anatomesh/field/stack/stack_warnings.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <string>
#include <utility>

namespace anatomesh {

namespace {

std::string text(double value) {
    std::array<char, 32> buffer;
    const auto end =
        std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed, 2);
    return {buffer.data(), end.ptr};
}

std::string structure_text(const Structure& structure) {
    return structure.name.empty() ? std::to_string(structure.number) : structure.name;
}

std::string slice_text(const ContourSet& set, std::uint32_t slice) {
    return set.slices[slice].name.empty() ? "slice " + std::to_string(slice) : set.slices[slice].name;
}

// The names of up to three structures, and how many more there are.
std::string names_of(const ContourSet& set, const std::vector<FewSlices>& few,
                     const std::vector<std::size_t>& which) {
    constexpr std::size_t most_named = 3;  // More names make a line that nobody reads. [names; >= 1; D]
    std::string names;
    for (std::size_t n = 0; n < std::min(most_named, which.size()); ++n)
        names += (n > 0 ? ", " : "") + structure_text(set.structures[few[which[n]].structure]);
    if (which.size() > most_named) names += " and " + std::to_string(which.size() - most_named) + " more";
    return names;
}

// Why slices came out as thick as they are; the keys under which structures are told together.
enum class ThickAs : std::uint8_t { source, others, nothing, ended_by_slices };

std::optional<ThickAs> told_as(const FewSlices& few, double made_mm) {
    // A slice that comes out thinner by more than this share is told. [1; 0 to 1; C 2 % of a volume]
    constexpr double thinner = 0.02;
    const bool is_known = few.by == ThicknessBy::option || few.by == ThicknessBy::source;
    if (few.slices.size() > 1 && is_known) return std::nullopt;
    if (few.slices.size() == 1 && few.mm > 0 && made_mm < (1 - thinner) * few.mm)
        return ThickAs::ended_by_slices;
    switch (few.by) {
        case ThicknessBy::option:
            return std::nullopt;
        case ThicknessBy::source:
            return ThickAs::source;
        case ThicknessBy::others:
            return ThickAs::others;
        case ThicknessBy::nothing:
            break;
    }
    return ThickAs::nothing;
}

const char* done_about(ThickAs way) {
    switch (way) {
        case ThickAs::source:
            return "it is as thick as the source says that a slice is; --slice-thickness gives another "
                   "thickness";
        case ThickAs::others:
            return "it is as thick as the slices of other structures are apart; --slice-thickness gives "
                   "another thickness";
        case ThickAs::ended_by_slices:
            return "slices beside it, which do not draw it, end it sooner than its thickness would; "
                   "--without leaves such a slice out";
        case ThickAs::nothing:
            break;
    }
    return "nothing says how thick a slice is, so that the distance of slices was taken; --slice-thickness "
           "states the thickness";
}

}  // namespace

void warn_about_few_slices(const ContourSet& set, const std::vector<FewSlices>& few,
                           const std::vector<double>& made_mm, RunContext& context) {
    for (const ThickAs way : {ThickAs::source, ThickAs::others, ThickAs::ended_by_slices, ThickAs::nothing}) {
        for (const std::size_t count : {std::size_t{1}, std::size_t{2}}) {
            std::vector<std::size_t> which;
            for (std::size_t n = 0; n < few.size(); ++n)
                if (few[n].slices.size() == count && told_as(few[n], made_mm[n]) == way) which.push_back(n);
            if (which.empty()) continue;
            const std::size_t first = which.front();
            std::string slices = slice_text(set, few[first].slices[0]);
            if (count > 1) slices += " and " + slice_text(set, few[first].slices[1]);
            std::string value = text(made_mm[first]) + " mm thick";
            if (which.size() > 1)
                value = std::to_string(which.size()) + " structures, the first on this slice and " + value;
            context.warn({"W-FLD-021",
                          count == 1 ? "drawn on one slice alone, so that nothing shows how it goes on above "
                                       "and below"
                                     : "drawn on two slices alone, so that nothing shows whether it goes on "
                                       "between and beyond them",
                          {set.source, slices, names_of(set, few, which), "", value},
                          done_about(way)});
        }
    }
}

void warn_about_knots(const ContourSet& set, std::uint32_t structure, const StructureKnots& knots,
                      RunContext& context) {
    const std::string name = structure_text(set.structures[structure]);
    // By the names of slices: heights along slices that lean or follow a path are those of a chart.
    const auto ends_of = [&](const SliceGap& gap) {
        return slice_text(set, gap.below) + " and " + slice_text(set, gap.above);
    };
    const auto warn_gap = [&](const SliceGap& gap, const char* code, const char* message, const char* done) {
        context.warn({code,
                      message,
                      {set.source, ends_of(gap), name, "", text(gap.high - gap.low) + " mm apart"},
                      done});
    };
    for (const auto& gap : knots.open_gaps) {
        warn_gap(gap, "W-FLD-001", "slices are missing inside the structure",
                 "the structure ends on both sides of the gap; --max-gap joins them");
    }
    for (const auto& gap : knots.bridged_gaps) {
        warn_gap(gap, "W-FLD-002", "slices are missing inside the structure",
                 "the structure was continued through the gap, where its shape is a guess");
    }
    if (!knots.gaps_by_groups.empty()) {
        const auto& first = knots.gaps_by_groups.front();
        context.warn(
            {"W-FLD-009",
             "the slices of the structure come in pairs or groups, with wide gaps between the groups",
             {set.source, ends_of(first), name, "",
              std::to_string(knots.gaps_by_groups.size()) + " gaps, the first " +
                  text(first.high - first.low) + " mm wide"},
             "the structure was continued through the gaps; draw separate parts as separate structures"});
    }
    if (set.drawn && !set.complete && !knots.not_drawn.empty()) {
        context.warn({"W-FLD-003",
                      "the structure is not drawn on every slice between its first and its last one",
                      {set.source, set.slices[knots.not_drawn.front()].name, name, "",
                       std::to_string(knots.not_drawn.size()) + " slices without it"},
                      "these slices were read as empty; leave out undrawn slices with --without"});
    }
    if (set.drawn && !knots.unknown.empty()) {
        context.warn(
            {"W-FLD-012",
             "the slices between those of the structure do not show it",
             {set.source, set.slices[knots.unknown.front()].name, name, "",
              std::to_string(knots.unknown.size()) + " slices without it"},
             "the structure was continued through them; if it ends there, draw it as two structures"});
    }
    if (knots.flat_island) {
        context.warn({"W-FLD-004",
                      "a part is drawn on a single slice, so that it cannot end flat there",
                      {set.source, "", name, "", ""},
                      "it extends half a slice to both sides"});
    }
}

void warn_about_jumps(const ContourSet& set, std::span<const StructureStack> stacks,
                      std::span<const std::uint32_t> slice_of_map, RunContext& context) {
    const auto slice_at = [&](std::int32_t map) {
        return slice_text(set, slice_of_map[static_cast<std::size_t>(map)]);
    };
    for (std::size_t s = 0; s < stacks.size(); ++s) {
        std::size_t jumps = 0;
        std::string first;
        for (std::size_t i = 0; i < stacks[s].pair_count(); ++i) {
            const StructureStack::Pair pair = stacks[s].pair(i);
            if (pair.motion->overlaps()) continue;
            if (jumps++ == 0) first = slice_at(pair.below) + " and " + slice_at(pair.above);
        }
        if (jumps == 0) continue;
        const std::string count =
            jumps == 1 ? "1 pair of slices" : std::to_string(jumps) + " pairs of slices";
        context.warn(
            {"W-FLD-005",
             "the contours of neighbouring slices do not overlap when seen along the normal",
             {set.source, first, structure_text(set.structures[s]), "", count},
             "they were joined where the outlines are close and face the same way; check the model there"});
    }
}

void warn_about_ambiguities(const ContourSet& set, std::span<const StructureStack> stacks,
                            std::span<const std::uint32_t> slice_of_map, const Plane& frame,
                            RunContext& context) {
    for (std::size_t s = 0; s < stacks.size(); ++s) {
        std::size_t places = 0;
        Ambiguity worst;
        StructureStack::Pair worst_pair{};
        for (std::size_t i = 0; i < stacks[s].pair_count(); ++i) {
            const StructureStack::Pair pair = stacks[s].pair(i);
            for (const Ambiguity& ambiguity : pair.motion->ambiguities()) {
                if (places++ > 0 && ambiguity.below + ambiguity.above <= worst.below + worst.above) continue;
                worst = ambiguity;
                worst_pair = pair;
            }
        }
        if (places == 0) continue;
        const auto name = [&](std::int32_t map) {
            return slice_text(set, slice_of_map[static_cast<std::size_t>(map)]);
        };
        const Vec3 at =
            frame.to_space(worst.at) + 0.5 * (worst_pair.below_high + worst_pair.above_low) * frame.normal;
        std::string value = std::to_string(worst.below) + " outlines and " + std::to_string(worst.above) +
                            " near " + text(at.x) + " " + text(at.y) + " " + text(at.z) + " mm";
        if (places > 1) value += ", the worst of " + std::to_string(places) + " places";
        context.warn(
            {"W-FLD-010",
             "neighbouring slices have different numbers of contours that overlap each other, so that their "
             "connection is ambiguous",
             {set.source, name(worst_pair.below) + " and " + name(worst_pair.above),
              structure_text(set.structures[s]), "", value},
             "they were joined by their overlaps; check the model there, or draw a slice between the two"});
    }
}

}  // namespace anatomesh
