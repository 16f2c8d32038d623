#include "anatomesh/contour/clean/resolved_slices.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <utility>

#include "anatomesh/base/number_text.h"
#include "anatomesh/contour/clean/rings_of_candidates.h"
#include "anatomesh/contour/resolve/resolve.h"

namespace anatomesh {

namespace {

// A slice is spread by more than this, or not at all. [mm; > 0; D rounding of doubles]
constexpr double spread_rounding_mm = 1e-9;
constexpr std::size_t most_names =
    4;  // A warning lists the names of at most so many planes. [names; >= 1; B]

// Checks what the file calls a hole against how the contour lies.
Status check_holes(const RawContours& raw, const Resolved& resolved, ReadingLog& log) {
    for (const RingReading& reading : resolved.readings) {
        if (reading.repeats >= 0) {
            ANATOMESH_CHECK_STATUS(
                check_repeat(raw, reading.source, static_cast<std::uint32_t>(reading.repeats)));
        }
        if (!raw.contours[reading.source].is_hole || !reading.adds) continue;
        log.note(reading.source, "W-CON-033",
                 "the file calls the contour a hole, but it lies outside all outlines of its structure or in "
                 "another hole",
                 "", "it was read as an outline of the structure");
    }
    return Nothing{};
}

// Adds the names of a slice's planes to an error about contradicting planes, because --without needs them.
Error with_names_of_planes(Error error, const CandidateSlice& slice) {
    if (error.code != "E-CON-007" || slice.given_names.size() < 2) return error;
    error.next_step += "; its planes: ";
    for (std::size_t n = 0; n < slice.given_names.size(); ++n)
        error.next_step += (n > 0 ? ", \"" : "\"") + slice.given_names[n] + "\"";
    return error;
}

std::string listed(const std::vector<std::string>& names) {
    std::string text;
    for (std::size_t i = 0; i < names.size() && i < most_names; ++i)
        text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
    if (names.size() > most_names) text += " and " + std::to_string(names.size() - most_names) + " more";
    return text;
}

Warning warning_of_spread(const RawContours& raw, const CandidateSlice& slice, const CleanOptions& options) {
    const bool is_one_plane = slice.given_names.size() < 2;
    std::string done = "they were read as one slice; points within " +
                       brief(options.planes.plane_tolerance_mm) + " mm of its plane stay where they are; ";
    if (is_one_plane) {
        done += "a contour inside another one is a hole, overlapping ones are united";
    } else if (options.rings.unite_repeated_planes) {
        done += "nearly equal contours are left out, contradicting ones are united";
    } else {
        done += "nearly equal contours are left out, contradicting ones are refused";
    }
    return {"W-CON-010",
            is_one_plane ? "contours of one slice lie in slightly different planes"
                         : "planes are so close to each other that they were read as one slice: " +
                               listed(slice.given_names),
            {raw.source, slice.name, "", "", brief(slice.spread_mm) + " mm"},
            done};
}

void log_readings(const std::vector<RingReading>& readings, ReadingLog& log) {
    for (const RingReading& reading : readings) {
        ContourLog& entry = log.of(reading.source);
        log.add_rule(reading.source, reading.rule);
        entry.points_kept = reading.points_kept;
        entry.max_displacement_mm = std::max(entry.max_displacement_mm, reading.displacement_mm);
        entry.area_change_mm2 += reading.area_change_mm2;
        if (reading.repaired) log.mark_repaired(reading.source);
    }
}

// Appends the rings to the last slice of the set, in an order that depends on their points alone.
void append_rings(std::vector<Ring> rings, std::uint32_t structure, ResolvedSlices& result) {
    for (Ring& ring : rings) {
        const auto first = std::min_element(ring.points.begin(), ring.points.end(),
                                            [](Vec3 p, Vec3 q) { return lexicographic_less(p, q); });
        std::rotate(ring.points.begin(), first, ring.points.end());
    }
    std::sort(rings.begin(), rings.end(),
              [](const Ring& p, const Ring& q) { return lexicographic_less(p.points[0], q.points[0]); });
    ContourSet& set = result.set;
    const auto slice = static_cast<std::uint32_t>(set.slices.size() - 1);
    for (const Ring& ring : rings) {
        set.contours.push_back({structure, slice, static_cast<std::uint32_t>(set.points.size()),
                                static_cast<std::uint32_t>(ring.points.size())});
        result.source_of.push_back(ring.source);
        set.points.insert(set.points.end(), ring.points.begin(), ring.points.end());
    }
}

// Resolves the structures that are drawn on one slice; `contours` are its candidates, by structure.
Status resolve_slice(const RawContours& raw, std::span<Candidate> candidates, const CandidateSlice& slice,
                     const CleanOptions& options, ReadingLog& log, RunContext& context,
                     ResolvedSlices& result) {
    const auto place_of = [&](std::uint32_t contour) {
        Place place = place_of_contour(raw, contour);
        place.slice = slice.name;
        return place;
    };
    double spread_of_one = 0;
    const std::vector<std::uint32_t>& members = slice.members;
    for (std::size_t begin = 0, end = 0; begin < members.size(); begin = end) {
        const std::uint32_t structure = raw.contours[candidates[members[begin]].raw].structure;
        while (end < members.size() && raw.contours[candidates[members[end]].raw].structure == structure)
            ++end;
        std::vector<Ring> rings;
        bool exclusive_or = false;
        for (std::size_t m = begin; m < end; ++m) {
            Candidate& candidate = candidates[members[m]];
            ANATOMESH_TRY(const double spread, move_onto_plane(raw, slice, options.planes, candidate, log));
            spread_of_one = std::max(spread_of_one, spread);
            exclusive_or |= raw.contours[candidate.raw].kind == ContourKind::closed_planar_xor;
            if (std::optional<Ring> ring =
                    ring_of(raw, slice.plane, options.rings.loop_mm2, std::move(candidate), log))
                rings.push_back(*std::move(ring));
        }
        if (rings.empty()) continue;
        Result<Resolved> resolved =
            resolve_rings(std::move(rings), slice.plane, exclusive_or, options.rings, place_of);
        if (!resolved.ok()) return with_names_of_planes(std::move(resolved).error(), slice);
        ANATOMESH_CHECK_STATUS(check_holes(raw, resolved.value(), log));
        log_readings(resolved.value().readings, log);
        log.append(std::move(resolved.value().notes));
        append_rings(std::move(resolved.value().rings), structure, result);
    }
    // The points of one contour spread by rounding; planes that differ spread the slice by more than that.
    if (slice.spread_mm > spread_of_one + spread_rounding_mm)
        context.warn(warning_of_spread(raw, slice, options));
    return Nothing{};
}

}  // namespace

Result<ResolvedSlices> resolve_slices(const RawContours& raw, std::vector<Candidate> candidates,
                                      const std::vector<CandidateSlice>& slices, const CleanOptions& options,
                                      ReadingLog& log, RunContext& context) {
    ResolvedSlices result;
    ContourSet& set = result.set;
    for (std::size_t s = 0; s < slices.size(); ++s) {
        if (context.cancelled()) return cancelled_error();
        context.report("clean", static_cast<double>(s) / static_cast<double>(slices.size()));
        const auto first = static_cast<std::uint32_t>(set.contours.size());
        set.slices.push_back({slices[s].plane, first, 0, slices[s].name});
        ANATOMESH_CHECK_STATUS(resolve_slice(raw, candidates, slices[s], options, log, context, result));
        const auto count = static_cast<std::uint32_t>(set.contours.size()) - first;
        set.slices.back().contour_count = count;
        if (count == 0) set.slices.pop_back();
    }
    return result;
}

}  // namespace anatomesh
