#include "anatomesh/cut/cut_corners.h"

#include <algorithm>
#include <span>

#include "anatomesh/base/sort_distinct.h"

namespace anatomesh {

namespace {

// The subsegments at the vertex, with those that earlier corners left.
std::vector<ContourOwners::Subsegment> subsegments_at(const NonmanifoldPatch& patch,
                                                      const CutSubsegments& cut, std::uint32_t v) {
    std::vector<ContourOwners::Subsegment> subsegments(patch.owners.subsegments_at(v).begin(),
                                                       patch.owners.subsegments_at(v).end());
    for (const auto& [a, b, structure] : cut.subsegments) {
        if (a == v) subsegments.push_back({b, structure});
        if (b == v) subsegments.push_back({a, structure});
    }
    return subsegments;
}

// The ways to make one disc of a body's surface in the star of a vertex.
class StarDiscs {
  public:
    StarDiscs(const NonmanifoldPatch& patch, std::span<const std::uint32_t> star, std::uint32_t vertex,
              std::span<const ContourOwners::Subsegment> subsegments)
        : patch_(patch), star_(star), vertex_(vertex), subsegments_(subsegments) {}

    // The cheapest of all ways to make one disc of the body's surface at v.
    std::vector<Region> one_disc(const std::vector<StarComponent>& components) const {
        std::vector<Region> best;
        std::array<std::size_t, 3> least{};
        const auto offer = [&](std::vector<Region> regions, bool path = false) {
            std::array<std::size_t, 3> price = cost(regions);
            if (path) price[2] = SIZE_MAX;  // a path may make another vertex non-manifold
            if (!best.empty() && price >= least) return;
            least = price;
            best = std::move(regions);
        };
        const StarParts parts = parts_of(components.front().body);
        for (std::uint32_t in = 0; in < parts.members.size(); ++in) {
            if (!parts.inside[in]) continue;
            std::vector<std::uint32_t> outs = parts.beside[in];
            std::sort(outs.begin(), outs.end());
            outs.erase(std::unique(outs.begin(), outs.end()), outs.end());
            for (const std::uint32_t out : outs) offer(corner_regions(parts, in, out));
        }
        for (const StarComponent& component : components) offer(bridged_regions(component), true);
        return best;
    }

  private:
    // The star of v as facet-connected components on the two sides of a body; cells by position in the star.
    struct StarParts {
        std::vector<std::vector<std::uint32_t>> members;  // by component
        std::vector<std::uint8_t> inside;                 // by component
        std::vector<std::uint32_t> component;             // by cell
        std::vector<std::vector<std::uint32_t>> across;   // by cell: cells across its facets at v
        // By component: components of the other side, with repeats.
        std::vector<std::vector<std::uint32_t>> beside;
    };
    StarParts parts_of(Body body) const {
        StarParts parts;
        parts.component.assign(star_.size(), no_cell);
        parts.across.resize(star_.size());
        for (std::uint32_t n = 0; n < star_.size(); ++n) {
            for (int i = 0; i < 4; ++i) {
                const std::uint32_t c = patch_.neighbors[star_[n]][i];
                if (patch_.cells[star_[n]][i] == vertex_ || c == no_cell) continue;
                parts.across[n].push_back(static_cast<std::uint32_t>(
                    std::lower_bound(star_.begin(), star_.end(), c) - star_.begin()));
            }
        }
        const auto inside = [&](std::uint32_t n) {
            return body.holds(patch_.table(), patch_.regions[star_[n]]);
        };
        for (std::uint32_t seed = 0; seed < star_.size(); ++seed) {
            if (parts.component[seed] != no_cell) continue;
            const auto id = static_cast<std::uint32_t>(parts.members.size());
            std::vector<std::uint32_t> members{seed};
            parts.component[seed] = id;
            for (std::size_t head = 0; head < members.size(); ++head) {
                for (const std::uint32_t m : parts.across[members[head]]) {
                    if (parts.component[m] != no_cell || inside(m) != inside(seed)) continue;
                    parts.component[m] = id;
                    members.push_back(m);
                }
            }
            parts.members.push_back(std::move(members));
            parts.inside.push_back(inside(seed));
        }
        parts.beside.resize(parts.members.size());
        for (std::uint32_t n = 0; n < star_.size(); ++n) {
            for (const std::uint32_t m : parts.across[n]) {
                if (parts.component[m] != parts.component[n])
                    parts.beside[parts.component[n]].push_back(parts.component[m]);
            }
        }
        return parts;
    }

    // New regions for the corners at v: of the discs that the body's surface makes in the star, the one
    // between these two components stays. Everything reached from the one inside without crossing to the
    // other becomes inside; the rest outside.
    std::vector<Region> corner_regions(const StarParts& parts, std::uint32_t main_in,
                                       std::uint32_t main_out) const {
        std::vector<Region> result;
        for (const std::uint32_t c : star_) result.push_back(patch_.regions[c]);
        std::vector<std::uint8_t> seen(parts.members.size(), 0);
        seen[main_in] = seen[main_out] = 1;
        for (const std::uint32_t root : {main_in, main_out}) {
            std::vector<std::uint32_t> queue{root};
            for (std::size_t head = 0; head < queue.size(); ++head) {
                for (const std::uint32_t p : parts.beside[queue[head]]) {
                    if (seen[p]) continue;
                    seen[p] = 1;
                    queue.push_back(p);
                    if (parts.inside[p] == parts.inside[root]) continue;
                    // The region of a cell of the parent component beside this one.
                    Region region = result[parts.members[queue[head]][0]];
                    for (const std::uint32_t n : parts.members[p]) {
                        for (const std::uint32_t m : parts.across[n]) {
                            if (parts.component[m] == queue[head]) region = result[m];
                        }
                    }
                    for (const std::uint32_t n : parts.members[p]) result[n] = region;
                }
            }
        }
        return result;
    }

    // What these regions would cost at v: contour vertices of structures and ends of subsegments of contour
    // segments that they would take off their surface, then cells that change.
    std::array<std::size_t, 3> cost(const std::vector<Region>& regions) const {
        std::array<std::size_t, 3> sum{};
        const auto off_surface = [&](std::uint32_t structure, std::uint32_t other) {
            bool in = false, out = false;
            for (std::size_t n = 0; n < star_.size(); ++n) {
                const Cell& cell = patch_.cells[star_[n]];
                if (other != no_cell && std::find(cell.begin(), cell.end(), other) == cell.end()) continue;
                (patch_.table().contains(regions[n], structure) ? in : out) = true;
            }
            return other == no_cell ? !(in && out) : in != out;  // neither: not an edge of the mesh
        };
        for (const std::uint32_t structure : patch_.owners.at(vertex_))
            sum[0] += off_surface(structure, no_cell);
        for (const ContourOwners::Subsegment& subsegment : subsegments_)
            sum[1] += off_surface(subsegment.structure, subsegment.other);
        for (std::size_t n = 0; n < star_.size(); ++n) sum[2] += regions[n] != patch_.regions[star_[n]];
        return sum;
    }

    // The other way to make one disc: a component of a side that has several is joined to the nearest other
    // component of that side by a path of cells of the star, all given the region from which it starts.
    std::vector<Region> bridged_regions(const StarComponent& start) const {
        std::vector<Region> result;
        for (const std::uint32_t c : star_) result.push_back(patch_.regions[c]);
        const auto position = [&](std::uint32_t c) {
            return std::lower_bound(star_.begin(), star_.end(), c) - star_.begin();
        };
        // It marks a cell that the search has not reached. [index that no cell has; 0xFFFFFFFE; D]
        constexpr std::uint32_t unseen = 0xFFFFFFFEu;
        std::vector<std::uint32_t> from(star_.size(), unseen), queue = start.cells;
        for (const std::uint32_t c : start.cells) from[position(c)] = no_cell;
        for (std::size_t head = 0; head < queue.size(); ++head) {
            const std::uint32_t c = queue[head];
            for (int i = 0; i < 4; ++i) {
                const std::uint32_t n = patch_.neighbors[c][i];
                if (patch_.cells[c][i] == vertex_ || n == no_cell || from[position(n)] != unseen) continue;
                from[position(n)] = c;
                queue.push_back(n);
                if (start.body.holds(patch_.table(), patch_.regions[n]) != start.inside) continue;
                // n is in another component: the way back from c to the start changes its region.
                std::uint32_t first = c;
                while (from[position(first)] != no_cell) first = from[position(first)];
                for (std::uint32_t step = c; step != no_cell; step = from[position(step)]) {
                    if (from[position(step)] != no_cell) result[position(step)] = patch_.regions[first];
                }
                return result;
            }
        }
        return result;
    }

    const NonmanifoldPatch& patch_;
    std::span<const std::uint32_t> star_;
    std::uint32_t vertex_;
    std::span<const ContourOwners::Subsegment> subsegments_;  // at the vertex
};

// The corners' points are appended to the patch's, and taken back if the cells do not fit. `corners`: their regions, by
// cell of the star.
bool cut_corner(NonmanifoldPatch& patch, std::span<const std::uint32_t> star, std::uint32_t v,
                const std::vector<Region>& corners, double share, PatchChange& change,
                CutSubsegments& segments) {
    std::vector<std::uint32_t> link;
    for (const std::uint32_t c : star) {
        for (const std::uint32_t u : patch.cells[c]) {
            if (u != v) link.push_back(u);
        }
    }
    sort_distinct(link);
    const std::uint32_t first_new = static_cast<std::uint32_t>(patch.points.size());
    for (const std::uint32_t u : link) {
        patch.points.push_back(patch.points[v] + share * (patch.points[u] - patch.points[v]));
    }
    const auto cut = [&](std::uint32_t u) {
        return first_new +
               static_cast<std::uint32_t>(std::lower_bound(link.begin(), link.end(), u) - link.begin());
    };
    LabelledCells added;
    for (std::size_t n = 0; n < star.size(); ++n) {
        std::array<std::uint32_t, 3> far{}, near{};
        int k = 0;
        for (const std::uint32_t u : patch.cells[star[n]]) {
            if (u == v) continue;
            far[k] = u;
            near[k++] = cut(u);
        }
        added.add({v, near[0], near[1], near[2]}, corners[n]);
        added.add_prism(near, far, patch.regions[star[n]]);
    }
    if (!fits(patch, star, added)) {
        patch.points.resize(first_new);
        return false;
    }
    change.replace(patch, star, added, first_new);
    for (const ContourOwners::Subsegment& subsegment : subsegments_at(patch, segments, v)) {
        if (!std::binary_search(link.begin(), link.end(), subsegment.other)) continue;
        segments.subsegments.push_back({v, cut(subsegment.other), subsegment.structure});
        segments.subsegments.push_back({cut(subsegment.other), subsegment.other, subsegment.structure});
        segments.vertices.push_back(cut(subsegment.other));
    }
    return true;
}

}  // namespace

std::uint64_t cut_corners(NonmanifoldPatch& patch, PatchStars& stars, double share, PatchChange& change,
                          CutSubsegments& segments) {
    std::uint64_t split = 0;
    std::vector<StarComponent> components;
    for (const std::uint32_t v : stars.nonmanifold) {
        const auto star = stars.stars.at(v);
        if (change.touches(star)) continue;
        stars.analyzer.surplus_components(v, components);
        if (components.empty()) continue;
        const std::vector<ContourOwners::Subsegment> subsegments = subsegments_at(patch, segments, v);
        const std::vector<Region> corners = StarDiscs(patch, star, v, subsegments).one_disc(components);
        split += cut_corner(patch, star, v, corners, share, change, segments);
    }
    return split;
}

}  // namespace anatomesh
