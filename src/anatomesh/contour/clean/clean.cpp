#include "anatomesh/contour/clean/clean.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "anatomesh/base/text.h"
#include "anatomesh/contour/clean/close_at_valve.h"
#include "anatomesh/contour/clean/crowded_points.h"
#include "anatomesh/contour/clean/resolve.h"
#include "anatomesh/contour/clean/weld.h"
#include "anatomesh/contour/model/chosen_slices.h"
#include "anatomesh/contour/model/message_text.h"
#include "anatomesh/contour/model/ring.h"
#include "anatomesh/contour/overlay/segment_index.h"
#include "anatomesh/contour/planes/empty_slices.h"
#include "anatomesh/contour/planes/plane_grouping.h"
#include "anatomesh/geom/box.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {

namespace {

constexpr double coordinate_bound_mm = 1e7;
constexpr double least_span_mm = 1;   // of all contours: below it the unit is most likely not the millimetre
constexpr double no_width_mm = 1e-6;  // a contour nowhere wider than this has no area
constexpr double crowded_span =
    1e-4;  // of all contours: points that crowd lie no farther apart, whatever the unit
constexpr double crowded_off = 0.1;  // of how near crowded points lie: so far off the line may one be
constexpr double speck_share =
    1e-4;  // of the area of a slip of the pen: that crosses itself in a box no larger

std::string structure_text(const Structure& structure) {
    return structure.name.empty() ? std::to_string(structure.number) : structure.name;
}

// A raw contour on its way: without repeated points, turned to its canonical start and direction.
struct Candidate {
    std::uint32_t raw = 0;
    std::vector<Vec3> points;
};

bool lexicographic_points_less(const std::vector<Vec3>& p, const std::vector<Vec3>& q) {
    return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end(),
                                        [](Vec3 a, Vec3 b) { return lexicographic_less(a, b); });
}

// Whether all points lie within `width` of one line.
bool has_no_width(const std::vector<Vec2>& points, double width) {
    Vec2 far = points[0];
    for (Vec2 p : points) {
        if (squared_length(p - points[0]) > squared_length(far - points[0])) far = p;
    }
    const Vec2 along = far - points[0];
    const double bound = width * length(along);
    return std::all_of(points.begin(), points.end(),
                       [&](Vec2 p) { return std::abs(cross(along, p - points[0])) <= bound; });
}

class Cleaner {
  public:
    Cleaner(const RawContours& raw, const CleanOptions& options, RunContext& context)
        : raw_(raw), options_(options), context_(context) {}

    Result<CleanResult> run() {
        start_log();
        note_structure_names();
        ANATOMESH_CHECK_STATUS(check_coordinates());
        ANATOMESH_CHECK_STATUS(gather());
        ANATOMESH_CHECK_STATUS(drop_repeats());
        fit_tolerances();
        group();
        ANATOMESH_CHECK_STATUS(leave_out_slices());
        ANATOMESH_CHECK_STATUS(resolve_slices());
        return finish();
    }

  private:
    Place place_of(std::uint32_t raw) const {
        const RawContour& contour = raw_.contours[raw];
        Place place;
        place.file = raw_.source;
        place.structure = structure_text(raw_.structures[contour.structure]);
        place.contour = contour.name.empty() ? std::to_string(raw) : contour.name;
        return place;
    }

    void note(std::uint32_t raw, std::string code, std::string message, std::string value, std::string done) {
        Place place = place_of(raw);
        place.value = std::move(value);
        notes_.push_back({raw, {std::move(code), std::move(message), std::move(place), std::move(done)}});
    }

    void drop(std::uint32_t raw, const std::string& why) { result_.log[raw].rule = "dropped: " + why; }

    std::span<const Vec3> points_of(const RawContour& contour) const {
        return {raw_.points.data() + contour.first_point, contour.point_count};
    }

    void start_log() {
        for (std::size_t c = 0; c < raw_.contours.size(); ++c) {
            const RawContour& contour = raw_.contours[c];
            assert(contour.structure < raw_.structures.size());
            assert(contour.plane < static_cast<std::int64_t>(raw_.planes.size()));
            assert(std::size_t{contour.first_point} + contour.point_count <= raw_.points.size());
            ContourLog log;
            log.raw_contour = static_cast<std::uint32_t>(c);
            log.points_in = contour.point_count;
            result_.log.push_back(log);
            result_.stats.points_in += contour.point_count;
        }
        result_.stats.contours_in = static_cast<std::uint32_t>(raw_.contours.size());
        repaired_.assign(raw_.contours.size(), 0);
        by_number_.resize(raw_.structures.size());
        std::iota(by_number_.begin(), by_number_.end(), 0u);
        std::stable_sort(by_number_.begin(), by_number_.end(), [&](std::uint32_t p, std::uint32_t q) {
            return raw_.structures[p].number < raw_.structures[q].number;
        });
        rank_.resize(by_number_.size());
        for (std::uint32_t i = 0; i < by_number_.size(); ++i) rank_[by_number_[i]] = i;
    }

    void note_structure_names() {
        std::map<std::string, const Structure*> seen;
        for (const Structure& structure : raw_.structures) {
            if (structure.name.empty()) continue;
            const auto [entry, is_new] = seen.try_emplace(lowered_without_blanks(structure.name), &structure);
            if (is_new) continue;
            context_.warn({"W-CON-002",
                           "two structures share a name but for case and blanks: numbers " +
                               std::to_string(entry->second->number) + " and " +
                               std::to_string(structure.number),
                           {raw_.source, "", structure.name, "", ""},
                           "both kept, told apart by number"});
        }
    }

    Status check_coordinates() const {
        for (std::size_t c = 0; c < raw_.contours.size(); ++c) {
            const std::span<const Vec3> points = points_of(raw_.contours[c]);
            for (std::size_t i = 0; i < points.size(); ++i) {
                const Vec3 p = points[i];
                for (double value : {p.x, p.y, p.z}) {
                    if (std::abs(value) <= coordinate_bound_mm) continue;
                    Place place = place_of(static_cast<std::uint32_t>(c));
                    place.contour += ", point " + std::to_string(i);
                    place.value = full(value);
                    if (!std::isfinite(value)) {
                        return Error{ErrorKind::input, "E-CON-002", "a coordinate is not a finite number",
                                     std::move(place), "correct or remove the contour"};
                    }
                    return Error{ErrorKind::input, "E-CON-003", "a coordinate is beyond 1e7 mm",
                                 std::move(place), "check the unit of the file: millimetres are expected"};
                }
            }
        }
        return Nothing{};
    }

    // Sorts out markers and open polylines, drops repeated points, and brings what is left into canonical
    // order.
    Status gather() {
        for (std::uint32_t c = 0; c < raw_.contours.size(); ++c) {
            const RawContour& contour = raw_.contours[c];
            if (contour.kind == ContourKind::point) {
                note(c, "W-CON-004", "a point marker bounds nothing", "", "left out of the surface");
                drop(c, "point marker");
                continue;
            }
            if (contour.point_count < 3) {
                note(c, "W-CON-003", "a contour of fewer than three points bounds nothing",
                     std::to_string(contour.point_count) + " points", "left out of the surface");
                drop(c, contour.point_count == 1   ? "one point"
                        : contour.point_count == 0 ? "no point"
                                                   : "two points");
                continue;
            }
            const bool is_open =
                contour.kind == ContourKind::open || contour.kind == ContourKind::open_at_valve;
            if (is_open && !closes(c)) continue;
            ANATOMESH_CHECK_STATUS(add_candidate(c));
        }
        std::stable_sort(candidates_.begin(), candidates_.end(), [&](const Candidate& p, const Candidate& q) {
            const std::uint32_t ps = rank_of(p.raw), qs = rank_of(q.raw);
            if (ps != qs) return ps < qs;
            return lexicographic_points_less(p.points, q.points);
        });
        return Nothing{};
    }

    std::uint32_t rank_of(std::uint32_t raw) const { return rank_[raw_.contours[raw].structure]; }

    // Whether an open polyline's gap is small: at most the option, and a quarter of the drawn length; or that
    // of a valve.
    bool closes(std::uint32_t c) {
        const std::span<const Vec3> points = points_of(raw_.contours[c]);
        double drawn = 0;
        for (std::size_t i = 1; i < points.size(); ++i) drawn += length(points[i] - points[i - 1]);
        const double gap = length(points.back() - points.front());
        if (gap <= options_.closing_gap_mm && gap <= 0.25 * drawn) {
            note(c, "W-CON-006", "an open contour with a small gap", brief(gap) + " mm",
                 "closed by a straight edge");
            result_.log[c].rule = "open, closed over " + brief(gap) + " mm";
            return true;
        }
        if (raw_.contours[c].kind == ContourKind::open_at_valve && closes_at_valve(c)) return true;
        note(c, "W-CON-005", "an open contour bounds nothing", "gap " + brief(gap) + " mm",
             "left out of the surface");
        drop(c, "open");
        return false;
    }

    bool closes_at_valve(std::uint32_t c) {
        std::vector<std::span<const Vec3>> others;
        for (const RawContour& other : raw_.contours) {
            const bool is_closed = other.kind == ContourKind::closed_planar && other.point_count > 2;
            if (is_closed && other.structure == raw_.contours[c].structure)
                others.push_back(points_of(other));
        }
        std::optional<ValveClosing> closing = close_at_valve(points_of(raw_.contours[c]), others);
        if (!closing) return false;
        const bool is_straight = closing->between.empty();
        note(c, "W-CON-029", "a contour open at a heart's valve", brief(closing->gap_mm) + " mm",
             is_straight ? std::string("closed by a straight edge across the valve")
                         : "closed beyond the valve, where others of the structure go on for " +
                               brief(closing->beyond_mm) + " mm");
        result_.log[c].rule = "open at the valve, closed over " + brief(closing->gap_mm) + " mm" +
                              (is_straight ? "" : ", " + brief(closing->beyond_mm) + " mm beyond it");
        closing_[c] = std::move(closing->between);
        return true;
    }

    Status add_candidate(std::uint32_t c) {
        const std::span<const Vec3> points = points_of(raw_.contours[c]);
        Candidate candidate{c, {points.begin(), points.end()}};
        if (const auto closing = closing_.find(c); closing != closing_.end())
            candidate.points.insert(candidate.points.end(), closing->second.begin(), closing->second.end());
        std::size_t repeated = drop_repeated_points(candidate.points);
        if (candidate.points.size() == 1) {
            return Error{ErrorKind::input, "E-CON-004", "all points of a contour are equal", place_of(c),
                         "remove the contour, or mark it as a point"};
        }
        // The usual way to say that a contour is closed is no blemish.
        if (repeated > 0 && points.front() == points.back()) --repeated;
        if (repeated > 0) {
            note(c, "W-CON-007", "points equal to their predecessor",
                 std::to_string(repeated) + (repeated == 1 ? " point" : " points"), "dropped");
            result_.log[c].rule = "repeated points dropped";
            repaired_[c] = 1;
        }
        canonicalize_cycle(candidate.points);
        candidates_.push_back(std::move(candidate));
        return Nothing{};
    }

    // Equal candidates of a structure stand together.
    Status drop_repeats() {
        std::vector<Candidate> kept;
        for (Candidate& candidate : candidates_) {
            if (!kept.empty() && rank_of(kept.back().raw) == rank_of(candidate.raw) &&
                kept.back().points == candidate.points) {
                // Stable sorting keeps the first of the input.
                ANATOMESH_CHECK_STATUS(check_repeat(candidate.raw, kept.back().raw));
                note(candidate.raw, "W-CON-011", "a contour repeats another one of its structure",
                     "contour " + place_of(kept.back().raw).contour, "dropped");
                result_.log[candidate.raw].rule = "repeat of " + std::to_string(kept.back().raw);
                continue;
            }
            kept.push_back(std::move(candidate));
        }
        candidates_ = std::move(kept);
        return Nothing{};
    }

    // A hole that is the outline itself leaves nothing of what is drawn, or nothing of it is a hole.
    Status check_repeat(std::uint32_t raw, std::uint32_t of) const {
        if (raw_.contours[raw].is_hole == raw_.contours[of].is_hole) return Nothing{};
        return Error{ErrorKind::geometry, "E-CON-012",
                     "a contour that the file calls a hole is an outline of its structure as well: contour " +
                         place_of(raw_.contours[raw].is_hole ? of : raw).contour,
                     place_of(raw_.contours[raw].is_hole ? raw : of), "take one of the two out of the file"};
    }

    // Tolerances in mm would swallow contours in metres.
    void fit_tolerances() {
        Box3 box;
        for (const Candidate& candidate : candidates_) {
            for (const Vec3& p : candidate.points) box.extend(p);
        }
        options_.crowded_mm = std::min(options_.crowded_mm, crowded_span * box.diagonal());
        if (candidates_.empty() || box.diagonal() >= least_span_mm) return;
        const double scale = box.diagonal() / least_span_mm;
        for (double* tolerance : {&options_.plane_tolerance_mm, &options_.group_tolerance_mm,
                                  &options_.corridor_mm, &options_.keyhole_mm, &options_.repeat_mm,
                                  &options_.doubtful_wall_mm, &options_.separation_mm, &options_.weld_mm})
            *tolerance *= scale;
        options_.loop_mm2 *= scale * scale;
        context_.warn({"W-CON-023",
                       "all contours together span less than 1 mm: is the file in metres or centimetres?",
                       {raw_.source, "", "", "", brief(box.diagonal()) + " mm"},
                       "taken as millimetres; if they are not, write the file in mm (1000 or 10 times the "
                       "numbers)"});
    }

    void group() {
        std::vector<ContourToPlace> contours;
        for (const Candidate& candidate : candidates_) {
            const RawContour& contour = raw_.contours[candidate.raw];
            contours.push_back({candidate.points, contour.plane, contour.structure});
        }
        groups_ = group_planes(
            contours, raw_.planes,
            {options_.plane_tolerance_mm, options_.plane_repair_mm, options_.group_tolerance_mm});
        members_.resize(groups_.slices.size());
        for (std::uint32_t c = 0; c < candidates_.size(); ++c) members_[groups_.slice_of[c]].push_back(c);
        name_slices();
        find_empty_planes();
    }

    // Planes of the file that no contour of it is on.
    void find_empty_planes() {
        std::vector<std::uint8_t> is_drawn(raw_.planes.size(), 0);
        for (const RawContour& contour : raw_.contours) {
            if (contour.plane >= 0) is_drawn[static_cast<std::size_t>(contour.plane)] = 1;
        }
        for (std::size_t p = 0; p < raw_.planes.size(); ++p) {
            if (is_drawn[p]) continue;
            const std::string given = p < raw_.plane_names.size() ? raw_.plane_names[p] : "";
            empty_planes_.push_back({raw_.planes[p], slice_text(raw_.planes[p], given, p)});
        }
    }

    // What the file calls the plane of a contour; may be empty.
    std::string given_name(std::uint32_t raw) const {
        const RawContour& contour = raw_.contours[raw];
        if (contour.plane < 0) return contour.slice;
        const auto plane = static_cast<std::size_t>(contour.plane);
        return plane < raw_.plane_names.size() ? raw_.plane_names[plane] : "";
    }

    void name_slices() {
        std::vector<std::set<std::string>> given(groups_.slices.size());
        for (std::size_t c = 0; c < candidates_.size(); ++c) {
            const std::string name = given_name(candidates_[c].raw);
            if (!name.empty()) given[groups_.slice_of[c]].insert(name);
        }
        for (std::size_t s = 0; s < groups_.slices.size(); ++s) {
            given_names_.emplace_back(given[s].begin(), given[s].end());
            names_.push_back(
                slice_text(groups_.slices[s], given[s].empty() ? std::string() : *given[s].begin(), s));
        }
    }

    // Those that the user names, before anything in them can be refused; of several planes of the file that
    // are one slice that alone which is called so.
    Status leave_out_slices() {
        if (options_.without.empty()) return Nothing{};
        std::vector<std::vector<std::string>> all;
        for (std::size_t s = 0; s < members_.size(); ++s) {
            all.push_back(given_names_[s]);
            if (all.back().size() < 2) all.back().insert(all.back().begin(), names_[s]);
        }
        for (const EmptyPlane& plane : empty_planes_) all.push_back({plane.name});
        ANATOMESH_TRY(const std::vector<std::uint8_t> is_named,
                      named_slices(all, options_.without, raw_.source));
        bool any = false;
        for (std::size_t s = 0; s < members_.size(); ++s) {
            const auto stays = [&](std::uint32_t c) {
                return !is_named[s] ||
                       (given_names_[s].size() > 1 && !is_without(given_name(candidates_[c].raw)));
            };
            std::vector<std::uint32_t> left;
            for (const std::uint32_t c : members_[s]) {
                if (stays(c)) {
                    left.push_back(c);
                    continue;
                }
                drop(candidates_[c].raw, "slice left out");
                const RawContour& contour = raw_.contours[candidates_[c].raw];
                result_.kept.left_out.push_back(
                    {raw_.structures[contour.structure].number, groups_.slices[s]});
            }
            members_[s] = std::move(left);
            any = any || !members_[s].empty();
        }
        return any ? Status(Nothing{}) : Status(no_slice_left(raw_.source));
    }

    bool is_without(const std::string& name) const {
        return std::any_of(options_.without.begin(), options_.without.end(), [&](const std::string& one) {
            return lowered_without_blanks(one) == lowered_without_blanks(name);
        });
    }

    // Moves points that are too far off their slice's plane onto it. `range` is how far the others spread
    // along the normal.
    Status check_plane(Candidate& candidate, std::uint32_t slice, double& range) {
        const Plane& plane = groups_.slices[slice];
        const int axis = axis_of(plane);
        double moved = 0, low = 0, high = 0;
        bool any = false;
        for (Vec3& p : candidate.points) {
            const double distance = plane.signed_distance(p);
            if (std::abs(distance) <= options_.plane_tolerance_mm) {
                low = any ? std::min(low, distance) : distance;
                high = any ? std::max(high, distance) : distance;
                any = true;
                continue;
            }
            if (std::abs(distance) > options_.plane_repair_mm)
                return off_plane(candidate.raw, slice, p, distance);
            moved = std::max(moved, std::abs(distance));
            p = p - distance * plane.normal;
            if (axis == 0) p.x = plane.origin.x;
            if (axis == 1) p.y = plane.origin.y;
            if (axis == 2) p.z = plane.origin.z;
        }
        if (moved > 0) {
            note(candidate.raw, "W-CON-009", "points lie off the plane of their contour",
                 brief(moved) + " mm", "moved onto slice " + names_[slice]);
            ContourLog& log = result_.log[candidate.raw];
            log.max_displacement_mm = std::max(log.max_displacement_mm, moved);
            log.rule = "moved onto its plane";
            repaired_[candidate.raw] = 1;
            drop_repeated_points(candidate.points);
        }
        range = high - low;
        return Nothing{};
    }

    Error off_plane(std::uint32_t raw, std::uint32_t slice, Vec3 point, double distance) const {
        const std::span<const Vec3> points = points_of(raw_.contours[raw]);
        const auto index = std::find(points.begin(), points.end(), point) - points.begin();
        Place place = place_of(raw);
        place.slice = names_[slice];
        place.contour += ", point " + std::to_string(index);
        place.value = brief(std::abs(distance)) + " mm";
        return {ErrorKind::input, "E-CON-005",
                "a point lies further than " + brief(options_.plane_repair_mm) +
                    " mm off the plane of its contour",
                std::move(place), "correct the contour, or raise the bound with --plane-repair"};
    }

    Status resolve_slices() {
        for (std::uint32_t s = 0; s < members_.size(); ++s) {
            if (context_.cancelled()) return cancelled_error();
            context_.report("clean", static_cast<double>(s) / static_cast<double>(members_.size()));
            ANATOMESH_CHECK_STATUS(resolve_slice(s));
        }
        return Nothing{};
    }

    Status resolve_slice(std::uint32_t s) {
        double range = 0;  // the largest of a contour by itself: rounding, as a rule
        open_slice(s);
        // Candidates are in the order of their structures' numbers.
        const std::vector<std::uint32_t>& members = members_[s];
        for (std::size_t begin = 0, end = 0; begin < members.size(); begin = end) {
            const std::uint32_t structure = raw_.contours[candidates_[members[begin]].raw].structure;
            std::vector<Ring> rings;
            bool exclusive_or = false;
            for (; end < members.size(); ++end) {
                Candidate& candidate = candidates_[members[end]];
                const RawContour& contour = raw_.contours[candidate.raw];
                if (contour.structure != structure) break;
                double own = 0;
                ANATOMESH_CHECK_STATUS(check_plane(candidate, s, own));
                range = std::max(range, own);
                exclusive_or |= contour.kind == ContourKind::closed_planar_xor;
                add_ring(std::move(candidate), s, rings);
            }
            if (rings.empty()) continue;
            auto resolved = resolve_rings(std::move(rings), groups_.slices[s], exclusive_or, options_,
                                          [&](std::uint32_t raw) { return place_in(s, raw); });
            if (!resolved.ok()) return with_planes(std::move(resolved).error(), s);
            ANATOMESH_CHECK_STATUS(check_holes(resolved.value()));
            take(std::move(resolved).value(), structure);
        }
        if (groups_.spread_mm[s] > range + 1e-9) {
            warn_of_spread(s);
        }
        close_slice();
        return Nothing{};
    }

    // What the file calls a hole and what lies as one.
    Status check_holes(const Resolved& resolved) {
        for (const RingReading& reading : resolved.readings) {
            if (reading.repeats >= 0) {
                ANATOMESH_CHECK_STATUS(
                    check_repeat(reading.source, static_cast<std::uint32_t>(reading.repeats)));
            }
            if (!raw_.contours[reading.source].is_hole || !reading.adds) continue;
            note(reading.source, "W-CON-033",
                 "a contour that the file calls a hole lies in no outline of its structure, or in another "
                 "hole",
                 "", "treated as part of the structure");
        }
        return Nothing{};
    }

    // With the names of a slice's planes, by which one can be left out.
    Error with_planes(Error error, std::uint32_t s) const {
        if (error.code != "E-CON-007" || given_names_[s].size() < 2) return error;
        error.next_step += "; its planes: ";
        for (std::size_t n = 0; n < given_names_[s].size(); ++n)
            error.next_step += (n > 0 ? ", \"" : "\"") + given_names_[s][n] + "\"";
        return error;
    }

    void warn_of_spread(std::uint32_t s) {
        // Names of up to this many planes are listed.
        constexpr std::size_t most_names = 4;
        const std::vector<std::string>& given = given_names_[s];
        std::string planes;
        for (std::size_t i = 0; i < given.size() && i < most_names; ++i) {
            planes += (i == 0 ? "" : i + 1 == given.size() ? " and " : ", ") + given[i];
        }
        if (given.size() > most_names)
            planes += " and " + std::to_string(given.size() - most_names) + " more";
        std::string done = "taken as one slice; points within " + brief(options_.plane_tolerance_mm) +
                           " mm of its plane stay where they are; ";
        if (given.size() < 2) {
            done += "a contour inside another one is a hole, overlapping ones are united";
        } else if (options_.unite_repeated_planes) {
            done += "nearly equal contours are dropped, contradicting ones united";
        } else {
            done += "nearly equal contours are dropped, contradicting ones refused";
        }
        context_.warn({"W-CON-010",
                       given.size() < 2 ? "contours of one slice lie on planes that differ"
                                        : "planes lie so near each other that they are one slice: " + planes,
                       {raw_.source, names_[s], "", "", brief(groups_.spread_mm[s]) + " mm"},
                       done});
    }

    // Crosses itself and is so small all over that it is noise of what drew it, whatever it bounds.
    bool is_speck(std::span<const Vec2> at) const {
        Box2 box;
        for (const Vec2 p : at) box.extend(p);
        if ((box.high.x - box.low.x) * (box.high.y - box.low.y) > speck_share * options_.loop_mm2)
            return false;
        std::vector<Segment2> segments;
        for (std::size_t n = 0; n < at.size(); ++n) segments.push_back({at[n], at[(n + 1) % at.size()]});
        bool crosses = false;
        SegmentIndex(segments).for_each_near_pair([&](std::uint32_t i, std::uint32_t j) {
            crosses = segment_contact(segments[i].a, segments[i].b, segments[j].a, segments[j].b) ==
                      SegmentContact::cross;
            return !crosses;
        });
        return crosses;
    }

    void add_ring(Candidate candidate, std::uint32_t s, std::vector<Ring>& rings) {
        const std::uint32_t raw = candidate.raw;
        const std::size_t before = candidate.points.size();
        Ring ring = make_ring(std::move(candidate.points), groups_.slices[s], raw);
        ring.plane = raw_.contours[raw].plane;
        const std::size_t spikes = remove_spikes(ring);
        if (ring.size() < 3 || has_no_width(ring.at, no_width_mm) || is_speck(ring.at)) {
            note(raw, "W-CON-008", "a contour without area", std::to_string(before) + " points",
                 "left out of the surface");
            drop(raw, "no area");
            return;
        }
        if (spikes > 0) {
            note(raw, "W-CON-012", "the contour turns back on itself",
                 std::to_string(spikes) + (spikes == 1 ? " point" : " points"),
                 "spikes removed; no other point moves");
            result_.log[raw].rule = "spikes removed";
            repaired_[raw] = 1;
        }
        rings.push_back(std::move(ring));
    }

    void add_rule(std::uint32_t raw, const std::string& rule) {
        std::string& text_so_far = result_.log[raw].rule;
        text_so_far += text_so_far.empty() ? rule : "; " + rule;
    }

    Place place_in(std::uint32_t s, std::uint32_t raw) const {
        Place place = place_of(raw);
        place.slice = names_[s];
        return place;
    }

    void open_slice(std::uint32_t s) {
        ContourSet& set = result_.kept;
        set.slices.push_back(
            {groups_.slices[s], static_cast<std::uint32_t>(set.contours.size()), 0, names_[s]});
    }

    void take(Resolved resolved, std::uint32_t structure) {
        for (const RingReading& reading : resolved.readings) {
            ContourLog& log = result_.log[reading.source];
            add_rule(reading.source, reading.rule);
            log.points_kept = reading.points_kept;
            log.max_displacement_mm = std::max(log.max_displacement_mm, reading.displacement_mm);
            log.area_change_mm2 += reading.area_change_mm2;
            if (reading.repaired) repaired_[reading.source] = 1;
        }
        for (RingNote& ring_note : resolved.notes) notes_.push_back(std::move(ring_note));
        // Every ring starts at its smallest vertex, and the rings of a structure are in the order of these.
        for (Ring& ring : resolved.rings) {
            const auto first = std::min_element(ring.points.begin(), ring.points.end(),
                                                [](Vec3 p, Vec3 q) { return lexicographic_less(p, q); });
            std::rotate(ring.points.begin(), first, ring.points.end());
        }
        std::sort(resolved.rings.begin(), resolved.rings.end(),
                  [](const Ring& p, const Ring& q) { return lexicographic_less(p.points[0], q.points[0]); });
        ContourSet& set = result_.kept;
        const auto slice = static_cast<std::uint32_t>(set.slices.size() - 1);
        for (const Ring& ring : resolved.rings) {
            set.contours.push_back({structure, slice, static_cast<std::uint32_t>(set.points.size()),
                                    static_cast<std::uint32_t>(ring.points.size())});
            source_of_.push_back(ring.source);
            set.points.insert(set.points.end(), ring.points.begin(), ring.points.end());
        }
    }

    void close_slice() {
        ContourSet& set = result_.kept;
        Slice& slice = set.slices.back();
        slice.contour_count = static_cast<std::uint32_t>(set.contours.size()) - slice.first_contour;
        if (slice.contour_count == 0) set.slices.pop_back();
    }

    // Structures in the order of their numbers; those without a contour left out.
    Status keep_structures() {
        ContourSet& set = result_.kept;
        std::vector<char> used(raw_.structures.size(), 0);
        for (const Contour& contour : set.contours) used[contour.structure] = 1;
        std::vector<std::uint32_t> new_index(raw_.structures.size(), 0);
        std::string names;
        for (std::uint32_t s : by_number_) {
            const std::string name = structure_text(raw_.structures[s]);
            names += (names.empty() ? "" : ", ") + name;
            if (used[s]) {
                new_index[s] = static_cast<std::uint32_t>(set.structures.size());
                set.structures.push_back(raw_.structures[s]);
            } else {
                context_.warn({"W-CON-001",
                               "a structure has no contour that bounds a surface",
                               {raw_.source, "", name, "", ""},
                               "left out"});
            }
        }
        if (set.structures.empty()) {
            return Error{ErrorKind::input,
                         "E-CON-001",
                         names.empty() ? "no contours, no structures" : "no contours; structures: " + names,
                         {raw_.source, "", "", "", ""},
                         "choose a file with closed planar contours"};
        }
        for (Contour& contour : set.contours) contour.structure = new_index[contour.structure];
        return Nothing{};
    }

    void keep_empty_planes() {
        std::erase_if(empty_planes_, [&](const EmptyPlane& plane) { return is_without(plane.name); });
        const std::vector<std::string> not_placed =
            keep_empty_slices(result_.kept, empty_planes_, options_.group_tolerance_mm);
        if (not_placed.empty()) return;
        context_.warn(
            {"W-CON-031",
             "planes without contours cross others, and how far they reach is not known",
             {raw_.source, not_placed.front(), "", "", std::to_string(not_placed.size()) + " planes"},
             "they tell nothing; what ends there is to be drawn on a plane that meets it"});
    }

    Status thin_crowds() {
        if (!has_crowded(result_.kept, options_.crowded_mm)) return Nothing{};
        // By point, whose it is.
        std::vector<std::pair<Vec3, std::uint32_t>> sources;
        for (std::size_t c = 0; c < result_.kept.contours.size(); ++c) {
            for (const Vec3& p : result_.kept.points_of(result_.kept.contours[c]))
                sources.push_back({p, source_of_[c]});
        }
        ANATOMESH_TRY(CrowdedPoints thin,
                      leave_out_crowded(std::move(result_.kept),
                                        {options_.crowded_mm, crowded_off * options_.crowded_mm}, context_));
        result_.kept = std::move(thin.kept);
        if (thin.left_out.empty()) return Nothing{};
        std::map<std::uint32_t, std::uint32_t> counts;
        for (const auto& [point, source] : sources)
            counts[source] += std::binary_search(thin.left_out.begin(), thin.left_out.end(), point,
                                                 [](Vec3 a, Vec3 b) { return lexicographic_less(a, b); });
        std::erase_if(counts, [](const auto& entry) { return entry.second == 0; });
        for (const auto& [raw, count] : counts) {
            ContourLog& log = result_.log[raw];
            log.points_kept -= std::min(log.points_kept, count);
            log.max_displacement_mm = std::max(log.max_displacement_mm, thin.distance_mm);
            add_rule(raw, "crowded points left out");
            repaired_[raw] = 1;
        }
        Place place = place_of(counts.begin()->first);
        place.value = std::to_string(thin.left_out.size()) + " points";
        context_.warn(
            {"W-CON-032",
             std::to_string(thin.left_out.size()) + " points lie nearer than " + brief(options_.crowded_mm) +
                 " mm to the next; the first such contour is named",
             std::move(place),
             "left out: they are within " + brief(thin.distance_mm) + " mm of the line that is kept"});
        return Nothing{};
    }

    void weld() {
        const WeldStats welded = weld_contours(result_.kept, options_.weld_mm);
        result_.stats.max_displacement_mm = welded.max_displacement_mm;
        if (welded.moved == 0) return;
        context_.warn({"W-CON-021",
                       std::to_string(welded.moved) +
                           " vertices differ from one of another structure by rounding alone",
                       {raw_.source, "", "", "", "at most " + full(welded.max_displacement_mm) + " mm"},
                       "moved onto it"});
    }

    Result<CleanResult> finish() {
        std::stable_sort(notes_.begin(), notes_.end(),
                         [](const RingNote& p, const RingNote& q) { return p.source < q.source; });
        for (RingNote& ring_note : notes_) context_.warn(std::move(ring_note.warning));
        ANATOMESH_CHECK_STATUS(keep_structures());
        ContourSet& set = result_.kept;
        set.frame = raw_.frame;
        set.pixel_mm = raw_.pixel_mm;
        set.source = raw_.source;
        if (options_.weld_mm > 0) weld();
        ANATOMESH_CHECK_STATUS(thin_crowds());
        keep_empty_planes();
        CleanStats& stats = result_.stats;
        stats.points_kept = set.points.size();
        stats.contours_kept = static_cast<std::uint32_t>(set.contours.size());
        for (char repaired : repaired_) stats.repaired += repaired;
        for (const ContourLog& log : result_.log) {
            stats.dropped += log.points_kept == 0;
            stats.max_displacement_mm = std::max(stats.max_displacement_mm, log.max_displacement_mm);
        }
        context_.report("clean", 1);
        return std::move(result_);
    }

    const RawContours& raw_;
    CleanOptions options_;
    RunContext& context_;
    std::vector<std::uint32_t> by_number_, rank_;  // structures in the order of their numbers, and back
    std::vector<Candidate> candidates_;
    PlaneGroups groups_;
    std::vector<std::vector<std::uint32_t>> members_;     // per slice, of candidates_
    std::vector<std::string> names_;                      // per slice
    std::vector<std::vector<std::string>> given_names_;   // per slice: of the planes in the file, sorted
    std::vector<EmptyPlane> empty_planes_;                // by their names for messages
    std::vector<char> repaired_;                          // per raw contour
    std::map<std::uint32_t, std::vector<Vec3>> closing_;  // by raw contour: what comes after its points
    std::vector<RingNote> notes_;
    std::vector<std::uint32_t> source_of_;  // per kept contour
    CleanResult result_;
};

}  // namespace

Result<CleanResult> clean_contours(const RawContours& raw, const CleanOptions& options, RunContext& context) {
    assert(options.plane_tolerance_mm >= 0 && options.plane_repair_mm >= options.plane_tolerance_mm);
    assert(options.group_tolerance_mm >= 0 && options.closing_gap_mm >= 0);
    assert(options.loop_mm2 >= 0 && options.keyhole_mm >= 0);
    assert(options.max_repair_area_share >= 0 && options.max_repair_area_share <= 1);
    return Cleaner(raw, options, context).run();
}

}  // namespace anatomesh
