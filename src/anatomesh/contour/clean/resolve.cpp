#include "anatomesh/contour/clean/resolve.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "anatomesh/contour/clean/close_loops.h"
#include "anatomesh/contour/clean/doubled_rings.h"
#include "anatomesh/contour/model/message_text.h"
#include "anatomesh/contour/overlay/combine.h"
#include "anatomesh/contour/overlay/nesting.h"
#include "anatomesh/contour/overlay/separate.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {

namespace {

constexpr double no_share = 1e-9;  // of an area: rounding of the area itself
constexpr std::size_t most_crossings = 4'000'000;

void append(std::string& rule, const std::string& more) {
    rule += rule.empty() ? more : "; " + more;
}

constexpr double doubtful_wall_of_radius = 0.1;

class Resolver {
  public:
    Resolver(std::vector<Ring> rings, const Plane& plane, bool exclusive_or, const CleanOptions& options,
             const PlaceOfSource& place_of)
        : rings_(std::move(rings)),
          plane_(plane),
          exclusive_or_(exclusive_or),
          options_(options),
          place_of_(place_of) {
        for (const Ring& ring : rings_) {
            readings_[ring.source].source = ring.source;
            readings_[ring.source].points_kept = static_cast<std::uint32_t>(ring.size());
        }
    }

    Result<Resolved> run() {
        open_corridors();
        drop_doubled();
        RingEdges edges(rings_);
        bool apart = keep_apart(edges, rings_);
        if (!apart && close_loops_of_all()) {
            edges = RingEdges(rings_);
            apart = keep_apart(edges, rings_);
        }
        if (!several_planes() && apart) {
            read_nesting(nest(edges, rings_));
            return finish(edges);
        }
        // Repeats on coincident planes are taken away one by one; everything else is settled in one go.
        std::optional<Combined> combined;
        for (bool again = true, first = true; again; first = false) {
            combined = combine_rings(rings_, plane_, rule(), options_.max_repair_area_share, most_crossings);
            if (!combined) {
                return Error{ErrorKind::limit, "E-CON-008", "the contours cross too often to be repaired",
                             place_of_(rings_.front().source), "repair the contours"};
            }
            if (first && unite_nested_planes(*combined)) continue;
            ANATOMESH_TRY(again, drop_plane_repeat(*combined));
        }
        ANATOMESH_CHECK_STATUS(read_fates(*combined));
        ANATOMESH_CHECK_STATUS(check_nesting_across_planes(*combined));
        rings_ = std::move(combined->rings);
        ANATOMESH_CHECK_STATUS(separate());
        return finish(RingEdges(rings_));
    }

  private:
    CombineRule rule() const {
        if (exclusive_or_) return CombineRule::exclusive_or;
        return options_.holes == HoleRule::united ? CombineRule::unite : CombineRule::nest_and_unite;
    }

    std::string number(std::uint32_t ring) const { return std::to_string(rings_[ring].source); }

    void note(std::uint32_t source, std::string code, std::string message, std::string value,
              std::string done) {
        Place place = place_of_(source);
        place.value = std::move(value);
        notes_.push_back({source, {std::move(code), std::move(message), std::move(place), std::move(done)}});
    }

    bool several_planes() const {
        return std::any_of(rings_.begin(), rings_.end(),
                           [&](const Ring& ring) { return ring.plane != rings_.front().plane; });
    }

    void open_corridors() {
        for (Ring& ring : rings_) {
            const std::size_t before = ring.size();
            double moved = close_corridors(ring, options_.corridor_mm);
            moved = std::max(moved, close_keyholes(ring, options_.keyhole_mm, options_.corridor_mm));
            if (moved == 0) continue;
            note(ring.source, "W-CON-013", "the contour runs back along itself in a narrow corridor",
                 brief(moved) + " mm", "corridor closed");
            RingReading& reading = readings_[ring.source];
            reading.repaired = true;
            reading.displacement_mm = moved;
            reading.points_kept -= static_cast<std::uint32_t>(before - ring.size());
            append(reading.rule, "corridor closed");
        }
        std::erase_if(rings_, [&](const Ring& ring) {
            if (ring.size() >= 3) return false;
            readings_[ring.source].points_kept = 0;
            append(readings_[ring.source].rule, "dropped: no area");
            return true;
        });
    }

    // An outline drawn again a hair off itself would leave a skin of that hair between the two.
    void drop_doubled() {
        std::vector<char> dropped(rings_.size(), 0);
        for (const DoubledRings& pair : find_doubled_rings(rings_, options_.repeat_mm)) {
            const Ring& ring = rings_[pair.smaller];
            if (dropped[pair.larger] || dropped[pair.smaller]) continue;
            dropped[pair.smaller] = 1;
            note(ring.source, "W-CON-011",
                 "a contour nearly repeats contour " + number(pair.larger) + " of its structure",
                 brief(pair.apart_mm) + " mm apart", "dropped");
            RingReading& reading = readings_[ring.source];
            reading.rule = "near repeat of " + number(pair.larger);
            reading.repeats = rings_[pair.larger].source;
            reading.points_kept = 0;
            reading.area_change_mm2 =
                std::abs(signed_area(rings_[pair.larger].at)) - std::abs(signed_area(ring.at));
        }
        std::size_t r = 0;
        std::erase_if(rings_, [&](const Ring&) { return dropped[r++] != 0; });
    }

    // Each contour by itself, so that what others do beside a loop is no part of it. Whether there was one.
    bool close_loops_of_all() {
        for (Ring& ring : rings_) {
            std::optional<ClosedLoops> closed = close_loops(
                ring, rings_, plane_, rule(), options_.max_repair_area_share, {options_.loop_mm2});
            if (!closed) continue;
            note(ring.source, "W-CON-030",
                 closed->loops == 1
                     ? "the contour crosses itself in a small loop"
                     : "the contour crosses itself in " + std::to_string(closed->loops) + " small loops",
                 brief(closed->area_mm2) + " mm2", "closed: no hole or island");
            RingReading& reading = readings_[ring.source];
            append(reading.rule,
                   std::to_string(closed->loops) + (closed->loops == 1 ? " loop closed" : " loops closed"));
            reading.area_change_mm2 += closed->area_mm2;
            reading.points_kept -= closed->points_dropped;
            reading.repaired = true;
            crossings_[ring.source] = closed->crossings;
            ring = std::move(closed->ring);
        }
        return !crossings_.empty();
    }

    // A hole that follows its outline everywhere: a thin wall, or the outline drawn twice? Only the user can
    // tell.
    void ask_about_thin_walls(const Nesting& nesting) {
        if (options_.holes == HoleRule::united && !exclusive_or_) return;
        for (const DoubledRings& pair :
             find_doubled_rings(rings_, options_.doubtful_wall_mm, doubtful_wall_of_radius)) {
            if (nesting.depth[pair.smaller] % 2 == 0 ||
                nesting.parent[pair.smaller] != static_cast<std::int32_t>(pair.larger))
                continue;
            note(rings_[pair.smaller].source, "W-CON-026",
                 "a hole follows its outline, contour " + number(pair.larger) +
                     ", all around: was it drawn twice?",
                 brief(pair.apart_mm) + " mm apart",
                 "read as a hole: what is left is the wall between the two");
        }
    }

    // With unite_repeated_planes: takes away every contour that bounds the region of its own plane where that
    // of another plane goes on, so that what is left by nesting bounds the union. Whether there was one.
    bool unite_nested_planes(const Combined& combined) {
        if (!options_.unite_repeated_planes || rule() != CombineRule::nest_and_unite) return false;
        std::vector<char> covered(rings_.size(), 0);
        for (std::uint32_t r = 0; r < rings_.size(); ++r) {
            const double area = combined.fates[r].area_mm2;
            std::map<std::int32_t, bool> inside;  // per plane, just outside of r
            inside[rings_[r].plane] = false;
            for (std::uint32_t q = 0; q < rings_.size(); ++q) {
                if (q == r || combined.fates[q].area_mm2 <= area) continue;
                const double common = combined.common_area(std::min(q, r), std::max(q, r));
                if (area - common <= no_share * area) inside[rings_[q].plane] ^= true;
            }
            covered[r] = std::any_of(inside.begin(), inside.end(), [&](const auto& plane) {
                return plane.second && plane.first != rings_[r].plane;
            });
        }
        if (std::none_of(covered.begin(), covered.end(), [](char c) { return c != 0; })) return false;
        std::vector<Ring> rest;
        for (std::uint32_t r = 0; r < rings_.size(); ++r) {
            if (!covered[r]) {
                rest.push_back(std::move(rings_[r]));
                continue;
            }
            RingReading& reading = readings_[rings_[r].source];
            append(reading.rule, "united with the other drawing of its plane, which covers it");
            reading.points_kept = 0;
            reading.repaired = true;
            note(rings_[r].source, "W-CON-022",
                 "a plane is given twice: this contour of plane " + std::to_string(rings_[r].plane) +
                     " lies inside what is drawn on the other",
                 brief(combined.fates[r].area_mm2) + " mm2", "united: adds nothing");
        }
        rings_ = std::move(rest);
        return true;
    }

    // A contour on the twin of a plane given twice: nearly the same as one there already is dropped (returns
    // true); one that contradicts it is an error.
    Result<bool> drop_plane_repeat(const Combined& combined) {
        for (std::uint32_t r = 0; r < rings_.size(); ++r) {
            for (std::uint32_t q = 0; q < r; ++q) {
                if (rings_[r].plane == rings_[q].plane) continue;
                const double common = combined.common_area(q, r);
                const double small = std::min(combined.fates[q].area_mm2, combined.fates[r].area_mm2);
                const double all = combined.fates[q].area_mm2 + combined.fates[r].area_mm2 - common;
                if (common <= no_share * small) continue;
                if (all - common <= options_.max_repair_area_share * all) {
                    note(rings_[r].source, "W-CON-018",
                         "a plane is given twice, with nearly the same contour " + number(q),
                         brief(all - common) + " mm2", "dropped");
                    RingReading& reading = readings_[rings_[r].source];
                    reading.rule = "near repeat of " + number(q);
                    reading.points_kept = 0;
                    reading.area_change_mm2 = all - common;
                    rings_.erase(rings_.begin() + r);
                    return true;
                }
                if (small - common <= no_share * small) continue;  // one inside the other: a hole
                if (options_.unite_repeated_planes) continue;
                Place place = place_of_(rings_[r].source);
                place.value = brief(all - common) + " mm2";
                return Error{ErrorKind::geometry, "E-CON-007",
                             "a plane is given twice and its contours contradict each other: contour " +
                                 place_of_(rings_[q].source).contour + " and this one",
                             std::move(place),
                             "leave one of the two planes out with --without, or unite them with "
                             "--unite-repeated-planes"};
            }
        }
        return false;
    }

    Status read_fates(const Combined& combined) {
        for (std::uint32_t r = 0; r < rings_.size(); ++r) {
            const RingFate& fate = combined.fates[r];
            RingReading& reading = readings_[rings_[r].source];
            reading.points_kept = fate.points_kept - std::min(fate.points_kept, crossings_[rings_[r].source]);
            ANATOMESH_CHECK_STATUS(read_self(r, fate, reading));
            if (exclusive_or_) {
                append(reading.rule, "exclusive or");
                continue;
            }
            const std::string parent = fate.parent < 0 ? "" : number(static_cast<std::uint32_t>(fate.parent));
            reading.adds = fate.parent < 0 || fate.level % 2 == 0;
            append(reading.rule, fate.parent < 0 || fate.level == 0 ? "outer"
                                 : fate.level % 2 == 1              ? "hole of " + parent
                                                                    : "island in hole " + parent);
            if (fate.protruding_area_mm2 > 0 && fate.level > 0) {
                note(rings_[r].source, "W-CON-017",
                     "a contour inside contour " + parent + " reaches beyond it",
                     brief(fate.protruding_area_mm2) + " mm2", "cut off");
                reading.area_change_mm2 += fate.protruding_area_mm2;
                reading.repaired = true;
            }
            if (fate.shares_edge) {
                note(rings_[r].source, "W-CON-016", "contours of one structure share an edge", "",
                     "joined along it");
                reading.repaired = true;
            }
        }
        if (!exclusive_or_) read_groups(combined);
        return Nothing{};
    }

    // A plane given twice, a contour on one of them inside a contour on the other: two drawings of one
    // outline as like as a hole, which only the user can tell.
    Status check_nesting_across_planes(const Combined& combined) {
        if (exclusive_or_ || options_.unite_repeated_planes) return Nothing{};
        for (std::uint32_t r = 0; r < rings_.size(); ++r) {
            const RingFate& fate = combined.fates[r];
            if (fate.parent < 0) continue;
            const auto parent = static_cast<std::uint32_t>(fate.parent);
            if (rings_[r].plane < 0 || rings_[parent].plane < 0 || rings_[r].plane == rings_[parent].plane)
                continue;
            const std::string message = "a plane is given twice: this contour lies inside contour " +
                                        place_of_(rings_[parent].source).contour + ", of the other one";
            const std::string value = brief(fate.area_mm2) + " mm2";
            if (fate.level % 2 == 1) {
                Place place = place_of_(rings_[r].source);
                place.value = value;
                return Error{ErrorKind::geometry, "E-CON-007", message, std::move(place),
                             "unite the two with --unite-repeated-planes or leave one of the planes out with "
                             "--without; if it "
                             "is a hole, put both contours on one plane"};
            }
            note(rings_[r].source, "W-CON-022", message, value,
                 fate.level > 0 ? "read as an island in a hole" : "adds nothing, holes are filled");
        }
        return Nothing{};
    }

    // What a contour did by itself.
    Status read_self(std::uint32_t r, const RingFate& fate, RingReading& reading) {
        const std::uint32_t source = rings_[r].source;
        if (fate.ambiguous_area_mm2 > no_share * fate.area_mm2) {
            const double share = std::min(1.0, fate.ambiguous_area_mm2 / fate.area_mm2);
            const std::string value = brief(fate.ambiguous_area_mm2) + " mm2, " + brief(100 * share) + " %";
            if (share > options_.max_repair_area_share) {
                Place place = place_of_(source);
                place.value = value;
                return Error{
                    ErrorKind::geometry, "E-CON-006",
                    "the contour crosses itself, and what it bounds is ambiguous by more than the bound",
                    std::move(place), "redraw the contour, or raise the bound with --max-repair"};
            }
            note(source, "W-CON-014", "the contour crosses itself", value, "read by the even-odd rule");
            append(reading.rule, "self-crossing, even-odd");
            reading.area_change_mm2 += fate.ambiguous_area_mm2;
            reading.repaired = true;
        } else if (fate.retraces_itself) {
            append(reading.rule, "keyhole, opened");
        } else if (fate.touches_itself) {
            note(source, "W-CON-015", "the contour touches itself", "", "split there");
            append(reading.rule, "split where it touches itself");
            reading.repaired = true;
        }
        return Nothing{};
    }

    // One warning for every group of united contours, at its first.
    void read_groups(const Combined& combined) {
        std::map<std::uint32_t, std::set<std::uint32_t>> groups;
        for (const RingOverlap& overlap : combined.overlaps) {
            auto& group = groups[combined.fates[overlap.first].group];
            group.insert(overlap.first);
            group.insert(overlap.second);
        }
        for (const auto& [group, rings] : groups) {
            const double area = combined.overlap_of_group_mm2[group];
            std::string others;
            std::uint32_t first = rings_[*rings.begin()].source;
            for (std::uint32_t r : rings) first = std::min(first, rings_[r].source);
            std::set<std::uint32_t> sources;
            for (std::uint32_t r : rings) sources.insert(rings_[r].source);
            for (std::uint32_t source : sources) {
                if (source != first) others += (others.empty() ? "" : ", ") + std::to_string(source);
                RingReading& reading = readings_[source];
                append(reading.rule, "united with others");
                reading.repaired = true;
                if (source == first) reading.area_change_mm2 += area;
            }
            note(first, "W-CON-019", "the contour overlaps others of its structure: " + others,
                 brief(area) + " mm2", "united");
        }
    }

    Status separate() {
        std::vector<Separation> done;
        if (!separate_rings(rings_, plane_, options_.separation_mm, done)) {
            return Error{ErrorKind::geometry, "E-CON-009",
                         "contours touch where there is no room to part them",
                         place_of_(rings_.front().source), "redraw the contours"};
        }
        for (const Separation& separation : done) {
            const std::uint32_t source = rings_[separation.ring].source;
            note(source, "W-CON-020", "two rings of one structure touch at a vertex",
                 std::to_string(separation.vertices) + (separation.vertices == 1 ? " vertex" : " vertices"),
                 "moved apart by " + brief(separation.displacement_mm) + " mm");
            RingReading& reading = readings_[source];
            reading.displacement_mm = std::max(reading.displacement_mm, separation.displacement_mm);
            reading.repaired = true;
        }
        return Nothing{};
    }

    void read_nesting(const Nesting& nesting) {
        for (std::size_t r = 0; r < rings_.size(); ++r) {
            RingReading& reading = readings_[rings_[r].source];
            reading.adds = nesting.depth[r] % 2 == 0;
            if (nesting.depth[r] == 0) {
                append(reading.rule, "outer");
            } else if (options_.holes == HoleRule::united && !exclusive_or_) {
                append(reading.rule, "dropped: inside another, holes are filled");
                reading.points_kept = 0;
            } else {
                append(reading.rule, (nesting.depth[r] % 2 == 1 ? "hole of " : "island in hole ") +
                                         number(static_cast<std::uint32_t>(nesting.parent[r])));
            }
        }
    }

    // Orients the rings, which keep apart, by their depth.
    Resolved finish(const RingEdges& edges) {
        const Nesting nesting = nest(edges, rings_);
        ask_about_thin_walls(nesting);
        Resolved resolved;
        for (std::size_t r = 0; r < rings_.size(); ++r) {
            if (options_.holes == HoleRule::united && !exclusive_or_ && nesting.depth[r] > 0) continue;
            const bool counter_clockwise = signed_area(rings_[r].at) > 0;
            if (counter_clockwise != (nesting.depth[r] % 2 == 0)) reverse_ring(rings_[r]);
            resolved.rings.push_back(std::move(rings_[r]));
            resolved.depth.push_back(nesting.depth[r]);
        }
        for (auto& [source, reading] : readings_) resolved.readings.push_back(std::move(reading));
        resolved.notes = std::move(notes_);
        return resolved;
    }

    std::vector<Ring> rings_;
    const Plane& plane_;
    const bool exclusive_or_;
    const CleanOptions& options_;
    const PlaceOfSource& place_of_;
    std::map<std::uint32_t, RingReading> readings_;     // by source
    std::map<std::uint32_t, std::uint32_t> crossings_;  // vertices that closing loops gave a source
    std::vector<RingNote> notes_;
};

}  // namespace

Result<Resolved> resolve_rings(std::vector<Ring> rings, const Plane& plane, bool exclusive_or,
                               const CleanOptions& options, const PlaceOfSource& place_of) {
    return Resolver(std::move(rings), plane, exclusive_or, options, place_of).run();
}

}  // namespace anatomesh
