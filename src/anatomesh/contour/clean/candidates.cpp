#include "anatomesh/contour/clean/candidates.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "anatomesh/base/number_text.h"
#include "anatomesh/contour/clean/close_at_valve.h"
#include "anatomesh/contour/model/ring.h"
#include "anatomesh/geom/numbers.h"

namespace anatomesh {

namespace {

// A gap wider than this share of the drawn length is no slip at the end of a contour. [1; 0 to 1; D a choice, measurement not recorded]
constexpr double closing_share = 0.25;

std::span<const Vec3> points_of(const RawContours& raw, std::uint32_t contour) {
    const RawContour& entry = raw.contours[contour];
    return {raw.points.data() + entry.first_point, entry.point_count};
}

bool lexicographic_points_less(const std::vector<Vec3>& p, const std::vector<Vec3>& q) {
    return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end(),
                                        [](Vec3 a, Vec3 b) { return lexicographic_less(a, b); });
}

// The points that close a contour which is open at a valve; nothing where it does not close.
std::optional<std::vector<Vec3>> closing_at_valve(const RawContours& raw, std::uint32_t c, ReadingLog& log) {
    std::vector<std::span<const Vec3>> others;
    for (std::uint32_t other = 0; other < raw.contours.size(); ++other) {
        const RawContour& entry = raw.contours[other];
        const bool is_closed = entry.kind == ContourKind::closed_planar && entry.point_count > 2;
        if (is_closed && entry.structure == raw.contours[c].structure)
            others.push_back(points_of(raw, other));
    }
    std::optional<ValveClosing> closing = close_at_valve(points_of(raw, c), others);
    if (!closing) return std::nullopt;
    const bool is_straight = closing->between.empty();
    log.note(c, "W-CON-029", "the contour is open at a heart valve", brief(closing->gap_mm) + " mm",
             is_straight
                 ? std::string("it was closed by a straight line across the valve")
                 : "it was closed beyond the valve, because other contours of the structure continue for " +
                       brief(closing->beyond_mm) + " mm");
    log.of(c).rule = "open at the valve, closed over " + brief(closing->gap_mm) + " mm" +
                     (is_straight ? "" : ", " + brief(closing->beyond_mm) + " mm beyond it");
    return std::move(closing->between);
}

// The points that close an open polyline, after its last one; none for a straight edge. Nothing where it stays
// open.
std::optional<std::vector<Vec3>> closing_of(const RawContours& raw, std::uint32_t c, double closing_gap_mm,
                                            ReadingLog& log) {
    const std::span<const Vec3> points = points_of(raw, c);
    double drawn = 0;
    for (std::size_t i = 1; i < points.size(); ++i) drawn += length(points[i] - points[i - 1]);
    const double gap = length(points.back() - points.front());
    if (gap <= closing_gap_mm && gap <= closing_share * drawn) {
        log.note(c, "W-CON-006", "the contour is open, with a small gap", brief(gap) + " mm",
                 "it was closed by a straight line");
        log.of(c).rule = "open, closed over " + brief(gap) + " mm";
        return std::vector<Vec3>();
    }
    if (raw.contours[c].kind == ContourKind::open_at_valve) {
        if (std::optional<std::vector<Vec3>> closing = closing_at_valve(raw, c, log)) return closing;
    }
    log.note(c, "W-CON-005", "the contour is open and encloses no area", "gap " + brief(gap) + " mm",
             "it was left out; --closing-gap closes wider gaps");
    log.drop(c, "open");
    return std::nullopt;
}

// Whether the contour bounds nothing because it is a marker or has too few points.
bool bounds_nothing(const RawContour& contour, std::uint32_t c, ReadingLog& log) {
    if (contour.kind == ContourKind::point) {
        log.note(c, "W-CON-004", "a point marker encloses no area", "", "it was left out");
        log.drop(c, "point marker");
        return true;
    }
    if (contour.point_count >= 3) return false;
    log.note(c, "W-CON-003", "a contour of fewer than three points encloses no area",
             std::to_string(contour.point_count) + " points", "it was left out");
    log.drop(c, contour.point_count == 1   ? "one point"
                : contour.point_count == 0 ? "no point"
                                           : "two points");
    return true;
}

Result<Candidate> candidate_of(const RawContours& raw, std::uint32_t c, const std::vector<Vec3>& closing,
                               ReadingLog& log) {
    const std::span<const Vec3> points = points_of(raw, c);
    Candidate candidate{c, {points.begin(), points.end()}};
    candidate.points.insert(candidate.points.end(), closing.begin(), closing.end());
    std::size_t repeated = drop_repeated_points(candidate.points);
    if (candidate.points.size() == 1) {
        return Error{ErrorKind::input, "E-CON-004", "all points of the contour are equal",
                     place_of_contour(raw, c), "remove the contour, or mark it as a point"};
    }
    // Many files repeat the first point at the end, to say that a contour is closed: this is no blemish.
    if (repeated > 0 && points.front() == points.back()) --repeated;
    if (repeated > 0) {
        log.note(c, "W-CON-007", "consecutive points are equal",
                 std::to_string(repeated) + (repeated == 1 ? " point" : " points"),
                 "the copies were removed");
        log.of(c).rule = "repeated points dropped";
        log.mark_repaired(c);
    }
    canonicalize_cycle(candidate.points);
    return candidate;
}

}  // namespace

std::vector<std::uint32_t> structures_by_number(const std::vector<Structure>& structures) {
    std::vector<std::uint32_t> order(structures.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t p, std::uint32_t q) {
        return structures[p].number < structures[q].number;
    });
    return order;
}

Status check_coordinates(const RawContours& raw) {
    for (std::uint32_t c = 0; c < raw.contours.size(); ++c) {
        const std::span<const Vec3> points = points_of(raw, c);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Vec3 p = points[i];
            for (double value : {p.x, p.y, p.z}) {
                if (std::abs(value) <= coordinate_bound_mm) continue;
                Place place = place_of_contour(raw, c);
                place.contour += ", point " + std::to_string(i);
                place.value = pointed_text(value);
                if (!std::isfinite(value)) {
                    return Error{ErrorKind::input, "E-CON-002", "a coordinate is not a finite number",
                                 std::move(place), "correct or remove the contour in the file"};
                }
                return Error{ErrorKind::input, "E-CON-003", "a coordinate is beyond 1e7 mm", std::move(place),
                             "check the unit of the file; the program expects millimetres"};
            }
        }
    }
    return Nothing{};
}

Result<std::vector<Candidate>> gather_candidates(const RawContours& raw, double closing_gap_mm,
                                                 ReadingLog& log) {
    std::vector<Candidate> candidates;
    for (std::uint32_t c = 0; c < raw.contours.size(); ++c) {
        const RawContour& contour = raw.contours[c];
        if (bounds_nothing(contour, c, log)) continue;
        std::optional<std::vector<Vec3>> closing = std::vector<Vec3>();
        if (contour.kind == ContourKind::open || contour.kind == ContourKind::open_at_valve)
            closing = closing_of(raw, c, closing_gap_mm, log);
        if (!closing) continue;
        ANATOMESH_TRY(Candidate candidate, candidate_of(raw, c, *closing, log));
        candidates.push_back(std::move(candidate));
    }
    const std::vector<std::uint32_t> by_number = structures_by_number(raw.structures);
    std::vector<std::uint32_t> rank(by_number.size());
    for (std::uint32_t i = 0; i < by_number.size(); ++i) rank[by_number[i]] = i;
    std::stable_sort(candidates.begin(), candidates.end(), [&](const Candidate& p, const Candidate& q) {
        const std::uint32_t ps = rank[raw.contours[p.raw].structure],
                            qs = rank[raw.contours[q.raw].structure];
        if (ps != qs) return ps < qs;
        return lexicographic_points_less(p.points, q.points);
    });
    return candidates;
}

Status drop_repeats(const RawContours& raw, std::vector<Candidate>& candidates, ReadingLog& log) {
    std::vector<Candidate> kept;
    for (Candidate& candidate : candidates) {
        const bool repeats =
            !kept.empty() &&
            raw.contours[kept.back().raw].structure == raw.contours[candidate.raw].structure &&
            kept.back().points == candidate.points;
        if (!repeats) {
            kept.push_back(std::move(candidate));
            continue;
        }
        ANATOMESH_CHECK_STATUS(check_repeat(raw, candidate.raw, kept.back().raw));
        log.note(candidate.raw, "W-CON-011", "the contour repeats another one of its structure",
                 "contour " + place_of_contour(raw, kept.back().raw).contour, "it was left out");
        log.of(candidate.raw).rule = "repeat of " + std::to_string(kept.back().raw);
    }
    candidates = std::move(kept);
    return Nothing{};
}

Status check_repeat(const RawContours& raw, std::uint32_t contour, std::uint32_t repeated) {
    if (raw.contours[contour].is_hole == raw.contours[repeated].is_hole) return Nothing{};
    const std::uint32_t hole = raw.contours[contour].is_hole ? contour : repeated;
    const std::uint32_t outline = raw.contours[contour].is_hole ? repeated : contour;
    return Error{ErrorKind::geometry, "E-CON-012",
                 "the file draws the same contour as a hole and as an outline of its structure: contour " +
                     place_of_contour(raw, outline).contour,
                 place_of_contour(raw, hole), "remove one of the two from the file"};
}

}  // namespace anatomesh
