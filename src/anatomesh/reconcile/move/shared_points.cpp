#include "anatomesh/reconcile/move/shared_points.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/geom/point_grid.h"
#include "anatomesh/reconcile/move/endpoint_groups.h"
#include "anatomesh/reconcile/move/reindex_points.h"

namespace anatomesh {

namespace {

// A place further from its group's point, across its contour, does not get the point. [mm; > 0; M 2026-11,
// set not recorded]
constexpr double joining_mm = 0.05;
// A moved vertex that is nearer to a shared point gives way to it. [mm; > 0; M 2026-11 fetal brain]
constexpr double merge_mm = 0.03;
// A vertex as drawn gives way if it is nearer than this share of its contour's mean segment: a file of few
// decimals leaves it beside the point that it was. [1; 0 to 0.5; M 2026-11 sets with 1e-9 to 1e-2 mm there]
constexpr double same_vertex_share = 0.005;
// It is also nearer than this share of its own shorter segment. [1; same_vertex_share to 0.5; M 2026-11, the
// same sets]
constexpr double same_vertex_share_of_own = 0.1;
// A shorter interval on a common line is none. [mm; > 0; M 2026-11 fetal brain]
constexpr double least_interval_mm = 0.001;
// Across a contour that runs along its line, places count as this sine away. [1, sine; 0 to 1; M 2026-11, set
// not recorded]
constexpr double least_sine_across = 0.01;

// A shared point that is put into a contour at its point `after`, or behind it.
struct Insertion {
    std::uint32_t after = 0;
    bool replaces = false;
    double distance = 0;  // from `after`
    std::uint32_t group = 0;
};

class SharedPointInsertion {
  public:
    SharedPointInsertion(ContourSet& set, std::span<const LineComparison> comparisons,
                         const std::vector<bool>& moved)
        : set_(set),
          moved_(moved),
          graph_(make_contour_graph(set)),
          ends_(place_endpoints(set, graph_, comparisons)),
          groups_(group_endpoints(set, ends_, comparisons)),
          gives_way_mm_(distances_to_give_way()),
          usable_(groups_.target.size(), true),
          insertions_(set.contours.size()) {
        put_on_lines();
        find_usable();
        join_near();
        for (std::size_t c = 0; c < comparisons.size(); ++c) {
            gather(comparisons[c].endpoints_a, ends_.of_a[c]);
            gather(comparisons[c].endpoints_b, ends_.of_b[c]);
        }
        for (auto& list : insertions_) sort_and_merge(list);
        drop_doubled();
    }

    SharedPoints run() {
        // What one slice cannot take is taken out of the others too, which are then checked again.
        for (bool dropped = true; dropped;) {
            dropped = false;
            for (const Slice& slice : set_.slices) dropped |= drop_unsound(slice);
        }
        lay_out();
        return {static_cast<std::uint64_t>(std::count(usable_.begin(), usable_.end(), true))};
    }

  private:
    // Returns, per point of the set, how near a shared point has to be for the point to give way to it. What
    // other contours have too stays as drawn, because these may not have the shared point.
    std::vector<double> distances_to_give_way() const {
        const std::vector<bool> stays = points_that_stay(set_, graph_);
        std::vector<double> distances(set_.points.size(), 0);
        for (const Contour& contour : set_.contours) {
            const auto segment = [&](std::uint32_t k) {
                return length(set_.points[point_after(contour, k)] - set_.points[k]);
            };
            const std::uint32_t end = contour.first_point + contour.point_count;
            double mean = 0;
            for (std::uint32_t k = contour.first_point; k < end; ++k)
                mean += segment(k) / contour.point_count;
            for (std::uint32_t k = contour.first_point; k < end; ++k) {
                const double shorter = std::min(segment(k), segment(point_before(contour, k)));
                if (!stays[k])
                    distances[k] = std::min(same_vertex_share * mean, same_vertex_share_of_own * shorter);
                if (moved_[k]) distances[k] = std::max(distances[k], merge_mm);
            }
        }
        return distances;
    }

    // A moved vertex is only as near to the line as the movement came, so its point is put onto the line.
    void put_on_lines() {
        for (std::size_t p = 0; p < ends_.on_nodes; ++p) {
            const std::uint32_t group = groups_.members[p].group;
            if (group == no_node || groups_.lines[group].size() != 1) continue;
            Vec3& target = groups_.target[group];
            const Line& line = groups_.lines[group].front();
            if (moved_[graph_.point_of_node[ends_.places[p].node]] && target == ends_.places[p].at)
                target = line.at(line.along(target));
        }
    }

    // Finds the groups whose places are within the bound, except for fewer than a third. Slices that could
    // not be brought there keep their places, and the others agree without them.
    void find_usable() {
        const std::size_t count = groups_.target.size();
        std::vector<std::uint32_t> within(count, 0), beyond(count, 0);
        left_out_.assign(ends_.places.size(), 0);
        for (std::size_t p = 0; p < ends_.places.size(); ++p) {
            const std::uint32_t group = groups_.members[p].group;
            if (group == no_node) continue;
            left_out_[p] = is_beyond(p);
            ++(left_out_[p] ? beyond : within)[group];
        }
        lacks_some_.assign(count, 0);
        for (std::uint32_t g = 0; g < count; ++g) {
            if (beyond[g] == 0) continue;
            lacks_some_[g] = groups_.lines[g].size() == 1 && 2 * beyond[g] < within[g];
            usable_[g] = lacks_some_[g];
        }
        put_between_the_others();
        for (std::size_t p = 0; p < ends_.places.size(); ++p) {
            const std::uint32_t group = groups_.members[p].group;
            if (group != no_node && lacks_some_[group] && !left_out_[p] && is_beyond(p))
                usable_[group] = false;
        }
    }

    bool is_beyond(std::size_t p) const {
        const EndpointGroups::Member& member = groups_.members[p];
        const double distance = length(groups_.target[member.group] - ends_.places[p].at);
        return distance * std::max(member.sine, least_sine_across) > joining_mm;
    }

    // A point that not all places reach becomes the mean of those that do.
    void put_between_the_others() {
        std::vector<double> sum(groups_.target.size(), 0), weights(groups_.target.size(), 0);
        for (std::size_t p = 0; p < ends_.places.size(); ++p) {
            const EndpointGroups::Member& member = groups_.members[p];
            if (member.group == no_node || !lacks_some_[member.group] || left_out_[p]) continue;
            const double weight = member.weight();
            sum[member.group] += weight * groups_.lines[member.group].front().along(ends_.places[p].at);
            weights[member.group] += weight;
        }
        for (std::uint32_t g = 0; g < sum.size(); ++g) {
            if (lacks_some_[g]) groups_.target[g] = groups_.lines[g].front().at(sum[g] / weights[g]);
        }
    }

    // Where slices meet in one point, all their pairs have a group there. Groups that are nearer to each
    // other than a vertex that gives way become one point.
    void join_near() {
        PointGrid grid(merge_mm, groups_.target.size());
        for (const Vec3& p : groups_.target) grid.add(p);
        apart_.resize(groups_.target.size());
        for (std::uint32_t g = 0; g < groups_.target.size(); ++g) {
            std::vector<std::uint32_t> near;
            grid.for_each_within(groups_.target[g], merge_mm, [&](std::uint32_t k, double) {
                if (usable_[k] && !apart_[k] && !lacks_some_[k]) near.push_back(k);
            });
            std::sort(near.begin(), near.end());
            if (!usable_[g] || apart_[g] || lacks_some_[g] || near.size() < 3) continue;
            const std::optional<Vec3> point = common_point(near, groups_.target[g]);
            for (std::size_t n = 0; point && n < near.size(); ++n) {
                apart_[near[n]] = std::exchange(groups_.target[near[n]], *point);
            }
        }
    }

    // Drops one of two points where an interval on a line has come to nothing, because its two ends are
    // one place.
    void drop_doubled() {
        PointGrid grid(least_interval_mm, groups_.target.size());
        for (const Vec3& p : groups_.target) grid.add(p);
        stands_in_.assign(groups_.target.size(), no_node);
        for (std::uint32_t g = 0; g < groups_.target.size(); ++g) {
            if (!usable_[g]) continue;
            grid.for_each_within(groups_.target[g], least_interval_mm, [&](std::uint32_t k, double) {
                if (usable_[k] && stands_for(k, g)) stands_in_[g] = std::min(stands_in_[g], k);
            });
            if (stands_in_[g] != no_node) usable_[g] = false;
        }
    }

    // Returns whether a group has a point on all contours of another one, and is the one of the two to
    // keep.
    bool stands_for(std::uint32_t kept, std::uint32_t other) const {
        const std::vector<std::uint32_t>&of = groups_.contours[other], &all = groups_.contours[kept];
        if (kept == other || lacks_some_[kept] || lacks_some_[other] ||
            !std::includes(all.begin(), all.end(), of.begin(), of.end()))
            return false;
        if (all.size() != of.size()) return true;
        if (apart_[kept].has_value() != apart_[other].has_value()) return apart_[kept].has_value();
        return kept < other;
    }

    // Groups that the dropped one stood for have points of their own again.
    void bring_back(std::uint32_t group) {
        for (std::size_t g = 0; g < stands_in_.size(); ++g) {
            if (stands_in_[g] != group) continue;
            stands_in_[g] = no_node;
            usable_[g] = true;
        }
    }

    // Returns nothing unless these are the groups of all pairs of some slices, one each. Otherwise a
    // contour would pass a line twice.
    std::optional<Vec3> common_point(std::span<const std::uint32_t> near, Vec3 beside) const {
        std::vector<Line> lines;
        std::vector<std::uint32_t> slices;
        for (const std::uint32_t g : near) {
            const std::size_t before = lines.size();
            add_lines(groups_.lines[g], lines);
            if (groups_.lines[g].size() != 1 || lines.size() != before + 1) return std::nullopt;
            slices.insert(slices.end(), groups_.slices[g].begin(), groups_.slices[g].end());
        }
        sort_distinct(slices);
        Vec3 point;
        if (2 * lines.size() != slices.size() * (slices.size() - 1) || !meeting_point(lines, beside, point))
            return std::nullopt;
        for (const std::uint32_t g : near) {
            if (length(point - groups_.target[g]) > merge_mm) return std::nullopt;
        }
        return point;
    }

    void gather(const std::vector<IntervalEndpoint>& ends, const std::vector<std::uint32_t>& places) {
        for (std::size_t e = 0; e < ends.size(); ++e) {
            const std::uint32_t group = groups_.members[places[e]].group;
            if (group == no_node || !usable_[group] || left_out_[places[e]]) continue;
            const IntervalEndpoint& end = ends[e];
            insertions_[end.contour].push_back({end.from, end.from == end.to,
                                                length(ends_.places[places[e]].at - set_.points[end.from]),
                                                group});
        }
    }

    static void sort_and_merge(std::vector<Insertion>& list) {
        std::sort(list.begin(), list.end(), [](const Insertion& p, const Insertion& q) {
            return std::tuple(p.after, !p.replaces, p.distance, p.group) <
                   std::tuple(q.after, !q.replaces, q.distance, q.group);
        });
        list.erase(std::unique(list.begin(), list.end(),
                               [](const Insertion& p, const Insertion& q) {
                                   return p.after == q.after && p.replaces == q.replaces &&
                                          p.group == q.group;
                               }),
                   list.end());
    }

    // A point of a contour, as shared points are put in.
    struct Link {
        Vec3 at;
        bool is_shared = false;
        double gives_way_mm = 0;  // to a shared point that is nearer
    };

    // Returns the contour with the points that `use` accepts; a point equal to its neighbour is there
    // once.
    template <class Use>
    std::vector<Vec3> with_points(std::uint32_t c, Use&& use) const {
        const Contour& contour = set_.contours[c];
        std::vector<Link> links;
        const auto add = [&](Link link) {
            if (links.empty() || links.back().at != link.at) {
                links.push_back(link);
            } else if (link.is_shared) {
                links.back() = link;
            }
        };
        auto next = insertions_[c].begin();
        for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
            Link link{set_.points[k], false, gives_way_mm_[k]};
            while (next != insertions_[c].end() && next->after == k && next->replaces) {
                if (use(next->group)) link = {groups_.target[next->group], true, 0};
                ++next;
            }
            add(link);
            for (; next != insertions_[c].end() && next->after == k; ++next) {
                if (use(next->group)) add({groups_.target[next->group], true, 0});
            }
        }
        while (links.size() > 1 && links.back().at == links.front().at) links.pop_back();
        return merged(links);
    }

    // Leaves out the vertices that give way to shared points beside them.
    static std::vector<Vec3> merged(const std::vector<Link>& links) {
        std::vector<Vec3> points;
        const std::size_t count = links.size();
        for (std::size_t n = 0; n < count; ++n) {
            const auto gives_way_to = [&](const Link& other) {
                return other.is_shared && length(other.at - links[n].at) < links[n].gives_way_mm;
            };
            if (links[n].gives_way_mm > 0 &&
                (gives_way_to(links[(n + 1) % count]) || gives_way_to(links[(n + count - 1) % count])))
                continue;
            // The vertex between two places of one point may have gone.
            if (points.empty() || points.back() != links[n].at) points.push_back(links[n].at);
        }
        while (points.size() > 1 && points.back() == points.front()) points.pop_back();
        return points;
    }

    template <class Use>
    bool is_sound(const Slice& slice, Use&& use) const {
        std::vector<PlaneRing> rings;
        for (std::uint32_t c = slice.first_contour; c < slice.first_contour + slice.contour_count; ++c) {
            PlaneRing ring{set_.contours[c].structure, {}};
            for (const Vec3& p : with_points(c, use)) ring.at.push_back(slice.plane.to_plane(p));
            if (ring.at.size() < 3) return false;
            rings.push_back(std::move(ring));
        }
        return slice_faults(rings, set_.exclusive).empty();
    }

    bool drop_unsound(const Slice& slice) {
        if (is_sound(slice, [&](std::uint32_t group) { return usable_[group]; })) return false;
        std::vector<std::uint32_t> groups;
        for (std::uint32_t c = slice.first_contour; c < slice.first_contour + slice.contour_count; ++c) {
            for (const Insertion& insertion : insertions_[c]) groups.push_back(insertion.group);
        }
        sort_distinct(groups);
        // The groups are tried one after the other, each with those before it that were sound.
        bool dropped = false;
        std::vector<std::uint32_t> sound;
        for (const std::uint32_t group : groups) {
            if (!usable_[group]) continue;
            sound.push_back(group);
            if (is_sound(slice,
                         [&](std::uint32_t g) { return std::binary_search(sound.begin(), sound.end(), g); }))
                continue;
            sound.pop_back();
            if (!part(group)) usable_[group] = false;
            bring_back(group);
            dropped = true;
        }
        return dropped;
    }

    // Gives the groups that were joined with this one their own points back. Returns whether it was
    // joined.
    bool part(std::uint32_t group) {
        if (!apart_[group]) return false;
        const Vec3 joint = groups_.target[group];
        for (std::size_t g = 0; g < apart_.size(); ++g) {
            if (!apart_[g] || groups_.target[g] != joint) continue;
            groups_.target[g] = *apart_[g];
            apart_[g].reset();
        }
        return true;
    }

    void lay_out() {
        std::vector<std::vector<Vec3>> fresh;
        for (std::uint32_t c = 0; c < set_.contours.size(); ++c)
            fresh.push_back(with_points(c, [&](std::uint32_t group) { return usable_[group]; }));
        reindex_points(set_, fresh);
    }

    ContourSet& set_;
    const std::vector<bool>& moved_;
    const ContourGraph graph_;
    const EndpointPlaces ends_;
    EndpointGroups groups_;
    const std::vector<double> gives_way_mm_;  // per point of the set
    std::vector<bool> usable_;
    std::vector<std::uint8_t> left_out_;              // per place: its slice keeps it where it is
    std::vector<std::uint8_t> lacks_some_;            // per group: of its places
    std::vector<std::optional<Vec3>> apart_;          // of groups that were joined: their own points
    std::vector<std::uint32_t> stands_in_;            // per group: the one that is used in its place
    std::vector<std::vector<Insertion>> insertions_;  // per contour, in its order
};

}  // namespace

SharedPoints insert_shared_points(ContourSet& set, std::span<const LineComparison> comparisons,
                                  const std::vector<bool>& moved) {
    return SharedPointInsertion(set, comparisons, moved).run();
}

}  // namespace anatomesh
