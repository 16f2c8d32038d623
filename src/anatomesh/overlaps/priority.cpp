#include "anatomesh/overlaps/priority.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/contour/clean/clean.h"
#include "anatomesh/contour/model/choose_structures.h"
#include "anatomesh/contour/model/chosen_slices.h"
#include "anatomesh/contour/model/message_text.h"
#include "anatomesh/contour/overlay/arrangement.h"
#include "anatomesh/contour/overlay/boundary_loops.h"
#include "anatomesh/geom/polygon.h"
#include "anatomesh/slices/coverage/covering_slices.h"

namespace anatomesh {

namespace {

constexpr std::uint32_t no_slice = 0xFFFFFFFFu;
constexpr double sliver_width_mm = 1e-3;
constexpr std::size_t most_edges = 20'000'000;
constexpr double least_given_mm2 = 1e-6;  // on a slice
constexpr double nested_share = 0.5;      // of the smaller of two: so much of it in the other
constexpr double most_across = 0.02;      // of a structure's area: to one of another level beside it
constexpr double most_shared = 0.1;       // of its outline, of what lies in another one: along the other's

// What any two structures have to do with each other, over all slices that draw both.
struct Relation {
    double common = 0;     // area
    double shared = 0;     // length of outlines that both have
    double area = 0;       // of the first one
    double perimeter = 0;  // the same
    bool alone = false;    // a slice between the first one's own draws the second one alone
    bool between = false;  // no slice draws both: of one's contours and those of the other's next slices
};

class Relations {
  public:
    explicit Relations(std::size_t count) : count_(count), all_(count * count) {}
    // From now on whole drawings count alone.
    void forget_own_slices() {
        for (Relation& relation : all_) relation.alone = true;
    }
    Relation& of(std::size_t s, std::size_t t) { return all_[s * count_ + t]; }
    const Relation& of(std::size_t s, std::size_t t) const { return all_[s * count_ + t]; }

  private:
    std::size_t count_;
    std::vector<Relation> all_;
};

bool are_one(const Plane& p, const Plane& q) {
    constexpr double same_mm = 0.01, same_turn = 1e-4;
    return length(p.normal - q.normal) < same_turn && std::abs(p.signed_distance(q.origin)) < same_mm;
}

// One slice: an arrangement of all its contours, and which structure owns each of its faces.
class SlicePartition {
  public:
    SlicePartition(const ContourSet& set, const Slice& slice, const std::vector<std::uint32_t>& rank)
        : set_(set), slice_(slice), rank_(rank) {}

    // Nothing when the contours cross too often.
    bool arrange_contours() {
        std::vector<Ring> rings;
        for (const Contour& contour : set_.contours_of(slice_)) {
            const auto points = set_.points_of(contour);
            rings.push_back(make_ring({points.begin(), points.end()}, slice_.plane,
                                      static_cast<std::uint32_t>(structures_.size())));
            structures_.push_back(contour.structure);
        }
        graph_ = arrange(rings, slice_.plane, most_edges);
        if (!graph_) return false;
        for (const Winding& winding : graph_->windings) owners_.push_back(owner_of(winding));
        return true;
    }

    // Adds what the structure keeps to `raw`; returns how much of its area it does not.
    double add_region(std::uint32_t structure, std::int32_t plane, RawContours& raw) const {
        double drawn = 0, kept = 0;
        std::vector<BoundaryEdge> boundary;
        for (const Arrangement::Edge& edge : graph_->edges) {
            const Vec2 origin = graph_->at[0];
            const double under = 0.5 * cross(graph_->at[edge.a] - origin, graph_->at[edge.b] - origin);
            const bool left = owners_[edge.left].owner == structure,
                       right = owners_[edge.right].owner == structure;
            if (left != right)
                boundary.push_back(left ? BoundaryEdge{edge.a, edge.b} : BoundaryEdge{edge.b, edge.a});
            kept += under * (left - right);
            drawn += under * (draws(edge.left, structure) - draws(edge.right, structure));
        }
        std::sort(boundary.begin(), boundary.end(), [](const BoundaryEdge& p, const BoundaryEdge& q) {
            return p.from != q.from ? p.from < q.from : p.to < q.to;
        });
        for (const std::vector<std::uint32_t>& loop : boundary_loops(graph_->at, boundary)) {
            std::vector<Vec2> at;
            for (const std::uint32_t edge : loop) at.push_back(graph_->at[boundary[edge].from]);
            if (2 * std::abs(signed_area(at)) <= sliver_width_mm * perimeter(at)) continue;
            RawContour contour;
            contour.structure = structure;
            contour.first_point = static_cast<std::uint32_t>(raw.points.size());
            contour.point_count = static_cast<std::uint32_t>(loop.size());
            contour.plane = plane;
            contour.name = slice_.name;
            for (const std::uint32_t edge : loop) raw.points.push_back(graph_->points[boundary[edge].from]);
            raw.contours.push_back(contour);
        }
        return drawn - kept;
    }

    void add_to(Relations& relations) const {
        const auto count = static_cast<std::uint32_t>(rank_.size());
        std::vector<double> area(count, 0), perimeter(count, 0);
        for (const Arrangement::Edge& edge : graph_->edges) {
            const Vec2 origin = graph_->at[0], a = graph_->at[edge.a] - origin,
                       b = graph_->at[edge.b] - origin;
            const double under = 0.5 * cross(a, b);
            for (const auto& [face, sign] : {std::pair{edge.left, 1}, std::pair{edge.right, -1}}) {
                for (const std::uint32_t s : owners_[face].drawn) {
                    area[s] += sign * under;
                    for (const std::uint32_t t : owners_[face].drawn)
                        relations.of(s, t).common += sign * under;
                }
            }
            std::vector<std::uint32_t> bounded;
            for (std::uint32_t s = 0; s < count; ++s) {
                if (draws(edge.left, s) != draws(edge.right, s)) bounded.push_back(s);
            }
            for (const std::uint32_t s : bounded) {
                perimeter[s] += length(b - a);
                for (const std::uint32_t t : bounded) relations.of(s, t).shared += length(b - a);
            }
        }
        for (std::uint32_t s = 0; s < count; ++s) {
            for (std::uint32_t t = 0; t < count; ++t) {
                if (!(perimeter[s] > 0 && perimeter[t] > 0)) continue;
                relations.of(s, t).area += area[s];
                relations.of(s, t).perimeter += perimeter[s];
            }
        }
    }

  private:
    static constexpr std::uint32_t nobody = 0xFFFFFFFFu;
    struct Face {
        std::uint32_t owner = nobody;
        std::vector<std::uint32_t> drawn;  // all structures there
    };

    Face owner_of(const Winding& winding) const {
        Face face;
        for (const RingTurns& turns : winding) {
            if (turns.turns % 2 == 0) continue;
            const std::uint32_t structure = structures_[turns.ring];
            const auto found = std::find(face.drawn.begin(), face.drawn.end(), structure);
            // Even-odd: a hole takes away what the contour around it draws.
            if (found == face.drawn.end()) {
                face.drawn.push_back(structure);
            } else {
                face.drawn.erase(found);
            }
        }
        for (const std::uint32_t structure : face.drawn) {
            if (face.owner == nobody || rank_[structure] < rank_[face.owner]) face.owner = structure;
        }
        return face;
    }
    bool draws(std::uint32_t face, std::uint32_t structure) const {
        const std::vector<std::uint32_t>& drawn = owners_[face].drawn;
        return std::find(drawn.begin(), drawn.end(), structure) != drawn.end();
    }

    const ContourSet& set_;
    const Slice& slice_;
    const std::vector<std::uint32_t>& rank_;
    std::vector<std::uint32_t> structures_;  // per ring
    std::optional<Arrangement> graph_;
    std::vector<Face> owners_;  // per winding
};

// By structure, of the slices that draw it.
std::vector<double> mean_areas(const ContourSet& set) {
    std::vector<double> areas(set.structures.size(), 0);
    std::vector<std::uint32_t> slices(set.structures.size(), 0), last(set.structures.size(), no_slice);
    for (const Contour& contour : set.contours) {
        // Those of a slice come one after the other.
        slices[contour.structure] += last[contour.structure] != contour.slice;
        last[contour.structure] = contour.slice;
        const std::span<const Vec3> points = set.points_of(contour);
        Vec3 twice;
        for (std::size_t n = 2; n < points.size(); ++n)
            twice += cross(points[n - 1] - points[0], points[n] - points[0]);
        areas[contour.structure] += 0.5 * dot(twice, set.slices[contour.slice].plane.normal);
    }
    for (std::size_t s = 0; s < areas.size(); ++s) areas[s] /= std::max(1u, slices[s]);
    return areas;
}

// All structures, those of `order` first.
std::vector<std::uint32_t> whole_order(const std::vector<std::uint32_t>& order, const ContourSet& set) {
    const std::vector<double> areas = mean_areas(set);
    std::vector<std::uint32_t> all = order;
    for (std::uint32_t s = 0; s < set.structures.size(); ++s) {
        if (std::find(order.begin(), order.end(), s) == order.end()) all.push_back(s);
    }
    std::stable_sort(all.begin() + static_cast<std::ptrdiff_t>(order.size()), all.end(),
                     [&](std::uint32_t s, std::uint32_t t) { return areas[s] < areas[t]; });
    return all;
}

// The slices of `part` among those of `whole`, of which it has some, in the same order; the others empty.
ContourSet on_all_slices(const ContourSet& part, const ContourSet& whole) {
    ContourSet all = part;
    all.slices.clear();
    all.contours.clear();
    std::size_t next = 0;
    for (const Slice& slice : whole.slices) {
        const auto first = static_cast<std::uint32_t>(all.contours.size());
        const auto number = static_cast<std::uint32_t>(all.slices.size());
        const bool is_here = next < part.slices.size() && part.slices[next].name == slice.name &&
                             are_one(part.slices[next].plane, slice.plane);
        all.slices.push_back({is_here ? part.slices[next].plane : slice.plane, first, 0, slice.name});
        if (!is_here) continue;
        for (Contour contour : part.contours_of(part.slices[next])) {
            contour.slice = number;
            all.contours.push_back(contour);
            ++all.slices.back().contour_count;
        }
        ++next;
    }
    return next == part.slices.size() ? all : part;
}

// Whether a structure lies in a larger one, which comes after it, and leaves it room all round.
// On the slices that draw both, if there is none between its own that draws the larger one alone: there what
// was drawn does not leave it the room that it has between its slices.
bool lies_in(std::uint32_t s, std::uint32_t outer, const Relations& relations,
             const std::vector<std::uint32_t>& rank) {
    const Relation &here = relations.of(s, outer), &whole = relations.of(s, s);
    const auto lies = [&](double area, double perimeter, double area_of_outer) {
        return area <= area_of_outer && here.common > least_given_mm2 && here.common >= nested_share * area &&
               here.shared <= most_shared * perimeter;
    };
    return rank[s] < rank[outer] &&
           ((!here.between && lies(whole.area, whole.perimeter, relations.of(outer, outer).area)) ||
            (!here.alone && lies(here.area, here.perimeter, relations.of(outer, s).area)));
}

// By structure, how many others it lies in, one in another.
std::vector<std::uint32_t> levels_of(const Relations& relations, const std::vector<std::uint32_t>& rank) {
    std::vector<std::uint32_t> by_rank(rank.size()), level(rank.size(), 0);
    for (std::uint32_t s = 0; s < rank.size(); ++s) by_rank[rank[s]] = s;
    // Those that others may lie in come last.
    for (std::size_t n = by_rank.size(); n-- > 0;) {
        const std::uint32_t s = by_rank[n];
        for (std::size_t m = n + 1; m < by_rank.size(); ++m) {
            if (lies_in(s, by_rank[m], relations, rank)) level[s] = std::max(level[s], level[by_rank[m]] + 1);
        }
    }
    return level;
}

// Whether a structure gives much to one of another level that does not lie in it: what is left would be a
// small difference of large volumes.
bool gives_much_across(const Relations& relations, const std::vector<std::uint32_t>& rank,
                       const std::vector<std::uint32_t>& level) {
    for (std::uint32_t s = 0; s < rank.size(); ++s) {
        for (std::uint32_t t = 0; t < rank.size(); ++t) {
            if (rank[t] < rank[s] && level[t] != level[s] && !lies_in(t, s, relations, rank) &&
                relations.of(s, t).common > most_across * relations.of(s, s).area)
                return true;
        }
    }
    return false;
}

bool overlap(const Box3& p, const Box3& q) {
    return p.low.x <= q.high.x && q.low.x <= p.high.x && p.low.y <= q.high.y && q.low.y <= p.high.y &&
           p.low.z <= q.high.z && q.low.z <= p.high.z;
}

std::vector<Box3> boxes_of(const ContourSet& set) {
    std::vector<Box3> boxes(set.structures.size());
    for (const Contour& contour : set.contours) {
        for (const Vec3& p : set.points_of(contour)) boxes[contour.structure].extend(p);
    }
    return boxes;
}

// Whether any two of them have anything in common, or may have between slices, of which none draws both.
bool have_walls(const ContourSet& set, const std::vector<std::uint32_t>& structures,
                const Relations& relations) {
    const std::vector<Box3> boxes = boxes_of(set);
    for (const std::uint32_t s : structures) {
        for (const std::uint32_t t : structures) {
            const Relation& relation = relations.of(s, t);
            if (s == t) continue;
            if (relation.common > least_given_mm2 || relation.shared > 0 ||
                (relation.perimeter == 0 && overlap(boxes[s], boxes[t])))
                return true;
        }
    }
    return false;
}

// Notes the slices that draw one structure alone between those of another one. Slices lie in their order
// where planes are parallel; elsewhere any slice is such a one.
void note_alone(const ContourSet& set, Relations& relations) {
    const auto count = static_cast<std::uint32_t>(set.structures.size());
    const bool in_order = all_parallel(set, parallel_tolerance_mm);
    std::vector<std::vector<bool>> draws(set.slices.size(), std::vector<bool>(count, false));
    for (const Contour& contour : set.contours) draws[contour.slice][contour.structure] = true;
    for (std::uint32_t s = 0; s < count; ++s) {
        const auto has = [&](const std::vector<bool>& slice) { return slice[s]; };
        auto first = std::find_if(draws.begin(), draws.end(), has);
        auto last = std::find_if(draws.rbegin(), draws.rend(), has).base();
        if (!in_order) first = draws.begin(), last = draws.end();
        for (auto slice = first; slice < last; ++slice) {
            for (std::uint32_t t = 0; t < count; ++t) {
                if (!(*slice)[s] && (*slice)[t]) relations.of(s, t).alone = true;
            }
        }
    }
}

// The slices that say something about any of the structures: all, unless they have slices of their own.
std::vector<std::uint32_t> slices_of(const ContourSet& set, const std::vector<std::uint32_t>& structures) {
    std::vector<std::uint32_t> all(set.slices.size()), drawn;
    std::iota(all.begin(), all.end(), 0u);
    if (structures.empty() || !all_parallel(set, parallel_tolerance_mm)) return all;
    std::vector<double> heights;
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        heights.push_back(dot(set.slices[s].plane.origin, set.slices.front().plane.normal));
        const auto contours = set.contours_of(set.slices[s]);
        if (std::any_of(contours.begin(), contours.end(), [&](const Contour& contour) {
                return std::find(structures.begin(), structures.end(), contour.structure) != structures.end();
            }))
            drawn.push_back(s);
    }
    if (drawn.empty()) return all;
    std::vector<double> left_out;
    for (const std::uint32_t s : structures) {
        const std::vector<double> own = heights_left_out(set, s, {}, set.slices.front().plane.normal);
        left_out.insert(left_out.end(), own.begin(), own.end());
    }
    sort_distinct(left_out);
    std::vector<std::uint32_t> covering = covering_slices(drawn, heights, left_out);
    return covering.size() == drawn.back() - drawn.front() + 1u ? all : covering;
}

// One slice: what it draws of a structure, and of another one what `beside` draws, moved onto its plane.
ContourSet together(const ContourSet& set, std::uint32_t slice, std::uint32_t structure, std::uint32_t beside,
                    std::uint32_t other) {
    ContourSet both;
    both.structures = set.structures;
    const Plane& plane = set.slices[slice].plane;
    for (const auto& [from, drawn] : {std::pair{slice, structure}, std::pair{beside, other}}) {
        for (Contour contour : set.contours_of(set.slices[from])) {
            if (contour.structure != drawn) continue;
            const auto points = set.points_of(contour);
            contour.slice = 0;
            contour.first_point = static_cast<std::uint32_t>(both.points.size());
            for (const Vec3& p : points) both.points.push_back(plane.to_space(plane.to_plane(p)));
            both.contours.push_back(contour);
        }
    }
    both.slices.push_back(
        {plane, 0, static_cast<std::uint32_t>(both.contours.size()), set.slices[slice].name});
    return both;
}

// How structures lie to each other that no slice draws together: each contour of one on the next slices of
// the other below and above it, half of both. Requires: parallel slices, in order.
void relate_between(const ContourSet& set, const std::vector<std::uint32_t>& rank, Relations& relations) {
    const auto count = static_cast<std::uint32_t>(set.structures.size());
    const std::vector<Box3> boxes = boxes_of(set);
    std::vector<std::vector<std::uint32_t>> drawn(count);
    for (const Contour& contour : set.contours) {
        if (drawn[contour.structure].empty() || drawn[contour.structure].back() != contour.slice)
            drawn[contour.structure].push_back(contour.slice);
    }
    for (std::uint32_t s = 0; s < count; ++s) {
        for (std::uint32_t t = 0; t < count; ++t) {
            if (s == t || relations.of(s, t).perimeter > 0 || !overlap(boxes[s], boxes[t])) continue;
            Relations found(count);
            for (const std::uint32_t slice : drawn[s]) {
                const auto above = std::upper_bound(drawn[t].begin(), drawn[t].end(), slice);
                if (above == drawn[t].begin() || above == drawn[t].end()) continue;
                for (const std::uint32_t beside : {*(above - 1), *above}) {
                    const ContourSet both = together(set, slice, s, beside, t);
                    SlicePartition partition(both, both.slices[0], rank);
                    if (partition.arrange_contours()) partition.add_to(found);
                }
            }
            if (found.of(s, t).common <= least_given_mm2 && found.of(s, t).shared == 0) continue;
            for (const auto& [p, q] : {std::pair{s, t}, std::pair{t, s}}) {
                Relation& relation = relations.of(p, q);
                const Relation& here = found.of(p, q);
                relation.common = 0.5 * here.common;
                relation.shared = 0.5 * here.shared;
                relation.area = 0.5 * here.area;
                relation.perimeter = 0.5 * here.perimeter;
                relation.between = true;
            }
        }
    }
}

Result<ContourSet> given_on_slices(const ContourSet& set, const std::vector<std::uint32_t>& rank,
                                   std::vector<GivenOverlap>& given, Relations* relations,
                                   RunContext& context);

std::vector<std::uint32_t> of_level(const std::vector<std::uint32_t>& level_of, std::uint32_t level) {
    std::vector<std::uint32_t> structures;
    for (std::uint32_t s = 0; s < level_of.size(); ++s) {
        if (level_of[s] == level) structures.push_back(s);
    }
    return structures;
}

// Nothing where no structure lies in another one.
Result<std::shared_ptr<const OverlappingContours>> overlapping_contours(
    const ContourSet& set, const std::vector<std::uint32_t>& rank, Relations& relations,
    const RunContext& context) {
    const std::size_t count = set.structures.size();
    std::vector<std::uint32_t> level_of = levels_of(relations, rank);
    // Of structures with walls between them every slice tells, unless they have slices of their own together;
    // else those of one's own help none.
    for (std::uint32_t level = 0; level < count; ++level) {
        const std::vector<std::uint32_t> own = of_level(level_of, level);
        if (have_walls(set, own, relations) && slices_of(set, own).size() == set.slices.size())
            relations.forget_own_slices();
    }
    level_of = levels_of(relations, rank);
    const std::uint32_t highest = *std::max_element(level_of.begin(), level_of.end());
    if (highest == 0 || gives_much_across(relations, rank, level_of) ||
        (highest + 1 < count && !all_parallel(set, parallel_tolerance_mm)))
        return std::shared_ptr<const OverlappingContours>();
    OverlappingContours overlapping;
    std::vector<std::uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return rank[a] < rank[b]; });
    for (const std::uint32_t s : order) overlapping.order.push_back(set.structures[s].number);
    for (std::uint32_t level = 0; level <= highest; ++level) {
        const std::vector<std::uint32_t> own = of_level(level_of, level);
        std::vector<std::uint32_t> own_rank;
        for (const std::uint32_t s : own) own_rank.push_back(rank[s]);
        ContourSet part = choose_structures(set, own);
        if (own.size() > 1) {
            RunContext apart;  // what is said of the whole set is said of it
            apart.cancel = context.cancel;
            std::vector<GivenOverlap> given(own.size());
            ANATOMESH_TRY(part, given_on_slices(part, own_rank, given, nullptr, apart));
            part = on_all_slices(part, set);
            if (part.slices.size() != set.slices.size())  // planes so near that they became one
                return std::shared_ptr<const OverlappingContours>();
        }
        // Those apart need not be told to be: each goes on through slices that draw others alone.
        part.exclusive = have_walls(set, own, relations);
        overlapping.slices.push_back(slices_of(set, part.exclusive ? own : std::vector<std::uint32_t>{}));
        if (overlapping.slices.back().size() < set.slices.size())
            part = chosen_slices(part, overlapping.slices.back());
        overlapping.levels.push_back(std::move(part));
    }
    return std::make_shared<const OverlappingContours>(std::move(overlapping));
}

Result<ContourSet> given_on_slices(const ContourSet& set, const std::vector<std::uint32_t>& rank,
                                   std::vector<GivenOverlap>& given, Relations* relations,
                                   RunContext& context) {
    RawContours raw;
    raw.structures = set.structures;
    raw.frame = set.frame;
    raw.pixel_mm = set.pixel_mm;
    raw.source = set.source;
    for (std::uint32_t k = 0; k < set.slices.size(); ++k) {
        raw.planes.push_back(set.slices[k].plane);
        raw.plane_names.push_back(set.slices[k].name);
        if (set.slices[k].contour_count == 0) continue;
        if (context.cancelled()) return cancelled_error();
        SlicePartition partition(set, set.slices[k], rank);
        if (!partition.arrange_contours()) {
            return Error{ErrorKind::geometry,
                         "E-PRI-001",
                         "the contours of a slice cross too often to be parted",
                         {set.source, set.slices[k].name, "", "", ""},
                         "give no order of the structures"};
        }
        if (relations != nullptr) partition.add_to(*relations);
        for (std::uint32_t s = 0; s < set.structures.size(); ++s) {
            const double area = partition.add_region(s, static_cast<std::int32_t>(k), raw);
            if (area <= least_given_mm2) continue;
            given[s].area_mm2 += area;
            ++given[s].slices;
        }
    }
    const std::size_t warnings = context.warnings.size();
    ANATOMESH_TRY(CleanResult cleaned, clean_contours(raw, {}, context));
    // Structures without contours: those that gave all.
    context.warnings.erase(std::remove_if(context.warnings.begin() + static_cast<std::ptrdiff_t>(warnings),
                                          context.warnings.end(),
                                          [](const Warning& warning) { return warning.code == "W-CON-001"; }),
                           context.warnings.end());
    ContourSet kept = std::move(cleaned.kept);
    kept.exclusive = true;
    kept.drawn = set.drawn;
    kept.left_out = set.left_out;
    return kept;
}

}  // namespace

Result<PriorityResult> give_overlaps(const ContourSet& set, const std::vector<std::uint32_t>& order,
                                     RunContext& context) {
    PriorityResult result;
    result.order = whole_order(order, set);
    std::vector<std::uint32_t> rank(result.order.size());
    for (std::uint32_t r = 0; r < rank.size(); ++r) rank[result.order[r]] = r;
    result.given.resize(set.structures.size());
    Relations relations(set.structures.size());
    ANATOMESH_TRY(result.kept, given_on_slices(set, rank, result.given, &relations, context));
    note_alone(set, relations);
    if (all_parallel(set, parallel_tolerance_mm)) relate_between(set, rank, relations);
    for (std::size_t s = 0; s < set.structures.size(); ++s) {
        const auto is_it = [&](const Structure& kept) { return kept.number == set.structures[s].number; };
        result.given[s].all =
            std::none_of(result.kept.structures.begin(), result.kept.structures.end(), is_it);
        if (result.given[s].all)
            context.warn({"W-PRI-001",
                          "the structure lies wholly in others that come before it",
                          {set.source, "", set.structures[s].name, "",
                           brief(result.given[s].area_mm2) + " mm2 on " +
                               std::to_string(result.given[s].slices) + " slices"},
                          "left out: there is nothing of it in the model; name it before them to keep it"});
    }
    result.kept = on_all_slices(result.kept, set);
    if (result.kept.slices.size() == set.slices.size()) {
        ANATOMESH_TRY(result.kept.overlapping, overlapping_contours(set, rank, relations, context));
    }
    return result;
}

}  // namespace anatomesh
