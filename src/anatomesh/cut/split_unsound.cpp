#include "anatomesh/cut/split_unsound.h"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "anatomesh/contour/model/message_text.h"
#include "anatomesh/geom/predicates.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/shape/quality.h"

namespace anatomesh {

namespace {

using Edge = std::array<std::uint32_t, 2>;

constexpr int most_relabellings = 20;  // passes that relabel components

// A part of the mesh round the unsound vertices, small enough to be rebuilt after every pass.
struct Patch {
    std::vector<Vec3>& points;  // of the whole mesh; only appended to
    std::vector<Cell> cells;
    std::vector<Region> regions;
    std::vector<CellNeighbors> neighbors;
    std::vector<std::uint32_t> watched;  // vertices whose stars lie wholly in the patch and may be unsound

    void rebuild_neighbors() {
        const std::vector<std::uint32_t> flat = cell_neighbors(cells, points.size());
        neighbors.resize(cells.size());
        for (std::size_t c = 0; c < cells.size(); ++c) {
            for (int i = 0; i < 4; ++i) neighbors[c][i] = flat[4 * c + i];
        }
    }
};

// What one pass takes out of the patch and puts in.
struct Change {
    std::vector<std::uint8_t> removed;  // by cell
    std::vector<Cell> cells;
    std::vector<Region> regions;

    void add(Cell cell, Region region) {
        cells.push_back(cell);
        regions.push_back(region);
    }
};

// What the cells have as facets, each with its orientation seen from outside; those between two of them, which
// have both, cancel. Nothing where a facet belongs to more than two. Lowest vertex first, in order.
using OrientedFacet = std::pair<std::array<std::uint32_t, 3>, int>;
std::optional<std::vector<OrientedFacet>> oriented_boundary(const std::vector<Cell>& cells) {
    std::vector<OrientedFacet> facets;
    for (const Cell& c : cells) {
        for (std::array<std::uint32_t, 3> f : {std::array{c[1], c[2], c[3]}, std::array{c[0], c[3], c[2]},
                                               std::array{c[0], c[1], c[3]}, std::array{c[0], c[2], c[1]}}) {
            std::rotate(f.begin(), std::min_element(f.begin(), f.end()), f.end());
            const int side = f[1] < f[2] ? 1 : -1;
            if (side < 0) std::swap(f[1], f[2]);
            facets.emplace_back(f, side);
        }
    }
    std::sort(facets.begin(), facets.end());
    std::vector<OrientedFacet> boundary;
    for (std::size_t n = 0; n < facets.size();) {
        std::size_t end = n + 1;
        while (end < facets.size() && facets[end].first == facets[n].first) ++end;
        if (end - n > 2) return std::nullopt;
        if (end - n == 1) boundary.push_back(facets[n]);
        if (end - n == 2 && facets[n].second == facets[n + 1].second) return std::nullopt;
        n = end;
    }
    return boundary;
}

bool positive(const std::vector<Vec3>& points, const Cell& c) {
    return orient3d(points[c[0]], points[c[1]], points[c[2]], points[c[3]]) > 0;
}

// Cuts a prism with triangle (a0, a1, a2) at one end and (b0, b1, b2) at the other into three cells. The diagonal of
// each side starts at the side's smallest vertex, so that two prisms agree on the side they share (Dompierre, Labbe,
// Vallet and Camarero, How to subdivide pyramids, prisms and hexahedra into tetrahedra, 1999). Orientation is the caller's.
void add_prism(std::array<std::uint32_t, 3> a, std::array<std::uint32_t, 3> b, Region region,
               Change& change) {
    // Turn the prism so that its smallest vertex is a[0].
    if (*std::min_element(b.begin(), b.end()) < *std::min_element(a.begin(), a.end())) std::swap(a, b);
    const std::ptrdiff_t turn = std::min_element(a.begin(), a.end()) - a.begin();
    std::rotate(a.begin(), a.begin() + turn, a.end());
    std::rotate(b.begin(), b.begin() + turn, b.end());
    // The two sides at a[0] are cut from a[0]; the third from its smallest vertex, which is a[1], a[2], b[1] or b[2].
    if (std::min(a[1], b[2]) < std::min(a[2], b[1])) {
        change.add({a[0], a[1], a[2], b[2]}, region);
        change.add({a[0], a[1], b[2], b[1]}, region);
    } else {
        change.add({a[0], a[1], a[2], b[1]}, region);
        change.add({a[0], b[1], a[2], b[2]}, region);
    }
    change.add({a[0], b[1], b[2], b[0]}, region);
}

// The cells round an edge in order, with the ring vertex before each: ring[n], ring[n + 1] belong to cells[n].
struct Ring {
    std::vector<std::uint32_t> cells, vertices;
    bool closed = false;
};

Ring ring_of(const Patch& patch, std::uint32_t first, Edge edge) {
    Ring ring;
    // The two other vertices of the first cell, so ordered that (a, b, c, d) is positive.
    const auto others = [&](std::uint32_t c) {
        std::array<std::uint32_t, 2> rest{};
        std::array<std::uint32_t, 4> order{edge[0], edge[1], 0, 0};
        int n = 0;
        for (const std::uint32_t v : patch.cells[c]) {
            if (v != edge[0] && v != edge[1]) rest[n++] = v;
        }
        order[2] = rest[0];
        order[3] = rest[1];
        if (!positive(patch.points, {order[0], order[1], order[2], order[3]})) std::swap(rest[0], rest[1]);
        return rest;
    };
    std::uint32_t c = first;
    do {
        const auto rest = others(c);
        ring.cells.push_back(c);
        ring.vertices.push_back(rest[0]);
        // Across the facet (a, b, rest[1]), opposite rest[0].
        const auto at =
            std::find(patch.cells[c].begin(), patch.cells[c].end(), rest[0]) - patch.cells[c].begin();
        c = patch.neighbors[c][at];
    } while (c != no_cell && c != first);
    ring.closed = c == first;
    return ring;
}

// Arcs of a ring: maximal runs of cells on one side of a body, as [begin, count) with wrap-around.
struct Arc {
    std::size_t begin, count;
};

std::vector<Arc> arcs_of(const Patch& patch, const Ring& ring, const RegionTable& table, Body body) {
    const std::size_t n = ring.cells.size();
    const auto inside = [&](std::size_t k) { return body.holds(table, patch.regions[ring.cells[k % n]]); };
    std::vector<Arc> arcs;
    for (std::size_t k = 0; k < n; ++k) {
        if (inside(k) == inside(k + n - 1)) continue;
        std::size_t count = 1;
        while (inside(k + count) == inside(k)) ++count;
        arcs.push_back({k, count});
    }
    return arcs;
}

class Splitter {
  public:
    Splitter(TetMesh& mesh, const ContourOwners& owners, RegionRegistry& registry,
             const SplitOptions& options)
        : mesh_(mesh),
          owners_(owners),
          registry_(registry),
          options_(options),
          patch_{mesh.points, {}, {}, {}, {}} {}

    Result<SplitStats> run(const std::vector<std::uint32_t>& unsound) {
        cut_out_patch(unsound);
        int relabellings = 0;
        for (int pass = 0; pass < options_.max_passes; ++pass) {
            find_unsound();
            if (unsound_.empty()) {
                put_patch_back();
                return stats_;
            }
            if (join_lost()) continue;
            change_ = {std::vector<std::uint8_t>(patch_.cells.size(), 0), {}, {}};
            const std::size_t before = stats_.edges_split + stats_.vertices_split;
            split_edges();
            if (stats_.edges_split + stats_.vertices_split == before) split_vertices();
            if (stats_.edges_split + stats_.vertices_split == before) {
                if (relabellings++ == most_relabellings || !relabel_components()) break;
                continue;
            }
            apply_change();
        }
        const Vec3 at = patch_.points[unsound_.front()];
        return Error{
            ErrorKind::geometry,
            "E-CUT-001",
            std::to_string(unsound_.size()) + " vertices of the surface stay non-manifold",
            {"", "", "", "", "first at " + brief(at.x) + ", " + brief(at.y) + ", " + brief(at.z) + " mm"},
            "try another --size"};
    }

  private:
    // Where no split has room, beside a cell that is nearly flat: the smallest component too many of each
    // vertex goes to the region round it. Says whether any did.
    bool relabel_components() {
        bool relabelled = false;
        std::vector<StarComponent> components;
        for (const std::uint32_t v : unsound_) {
            analyzer_->excess_components(v, components);
            std::erase_if(components, [](const StarComponent& component) { return component.largest; });
            if (components.empty()) continue;
            const StarComponent& least = *std::min_element(
                components.begin(), components.end(), [](const StarComponent& x, const StarComponent& y) {
                    return x.cells.size() < y.cells.size();
                });
            relabelled = relabel_to_other_side(v, least) || relabelled;
        }
        return relabelled;
    }

    // To the region with which the component shares the most facets at the vertex across its body's surface.
    bool relabel_to_other_side(std::uint32_t vertex, const StarComponent& component) {
        std::map<Region, int> facets;
        for (const std::uint32_t c : component.cells) {
            for (std::size_t i = 0; i < 4; ++i) {
                const std::uint32_t n = patch_.neighbors[c][i];
                if (patch_.cells[c][i] != vertex && n != no_cell &&
                    component.body.holds(registry_.table(), patch_.regions[n]) != component.inside)
                    ++facets[patch_.regions[n]];
            }
        }
        if (facets.empty()) return false;
        const Region region =
            std::max_element(facets.begin(), facets.end(), [](const auto& x, const auto& y) {
                return x.second < y.second;
            })->first;
        for (const std::uint32_t c : component.cells) patch_.regions[c] = region;
        ++stats_.components_relabelled;
        return true;
    }

    // Takes all cells that touch a vertex of the stars of the unsound vertices out of the mesh into the patch.
    void cut_out_patch(const std::vector<std::uint32_t>& unsound) {
        std::vector<std::uint8_t> reach(mesh_.points.size(), 0);  // 1: unsound, 2: in such a star
        for (const std::uint32_t v : unsound) reach[v] = 1;
        for (int ring = 1; ring <= 2; ++ring) {
            std::vector<std::uint8_t> grown = reach;
            for (const Cell& cell : mesh_.cells) {
                const bool touches =
                    std::any_of(cell.begin(), cell.end(), [&](std::uint32_t v) { return reach[v] != 0; });
                if (!touches) continue;
                for (const std::uint32_t v : cell) {
                    if (!grown[v]) grown[v] = static_cast<std::uint8_t>(ring + 1);
                }
            }
            reach = std::move(grown);
        }
        // Vertices within two steps have all their cells in the patch if the cells at them are taken.
        std::size_t kept = 0;
        for (std::size_t c = 0; c < mesh_.cells.size(); ++c) {
            const Cell& cell = mesh_.cells[c];
            if (std::any_of(cell.begin(), cell.end(), [&](std::uint32_t v) { return reach[v] != 0; })) {
                patch_.cells.push_back(cell);
                patch_.regions.push_back(mesh_.regions[c]);
            } else {
                mesh_.cells[kept] = cell;
                mesh_.regions[kept++] = mesh_.regions[c];
            }
        }
        mesh_.cells.resize(kept);
        mesh_.regions.resize(kept);
        for (std::uint32_t v = 0; v < reach.size(); ++v) {
            if (reach[v]) patch_.watched.push_back(v);
        }
        patch_.rebuild_neighbors();
    }

    void put_patch_back() {
        mesh_.cells.insert(mesh_.cells.end(), patch_.cells.begin(), patch_.cells.end());
        mesh_.regions.insert(mesh_.regions.end(), patch_.regions.begin(), patch_.regions.end());
    }

    void find_unsound() {
        stars_.emplace(patch_.cells, patch_.points.size());
        analyzer_.emplace(patch_.cells, patch_.neighbors, *stars_, patch_.regions, registry_.table(),
                          owners_);
        unsound_.clear();
        for (const std::uint32_t v : patch_.watched) {
            if (analyzer_->defect(v) > 0) unsound_.push_back(v);
        }
    }

    // Move 1. Returns whether a cell changed its region.
    bool join_lost() {
        bool joined = false;
        std::vector<std::uint32_t> lost;
        for (const std::uint32_t v : unsound_) {
            analyzer_->lost_structures(v, lost);
            if (lost.empty()) continue;
            const std::vector<std::uint32_t> structures = lost;
            for (const std::uint32_t structure : structures) joined = join(v, structure) || joined;
        }
        return joined;
    }

    // Breadth-first from the cells at the vertex to the nearest cell on the other side; the path changes side.
    bool join(std::uint32_t vertex, std::uint32_t structure) {
        constexpr std::uint32_t unseen = 0xFFFFFFFEu;
        std::vector<std::uint32_t> from(patch_.cells.size(), unseen), queue;
        const bool was_inside = registry_.table().contains(patch_.regions[stars_->at(vertex)[0]], structure);
        for (const std::uint32_t c : stars_->at(vertex)) {
            from[c] = no_cell;
            queue.push_back(c);
        }
        for (std::size_t head = 0; head < queue.size(); ++head) {
            const std::uint32_t c = queue[head];
            for (const std::uint32_t n : patch_.neighbors[c]) {
                if (n == no_cell || from[n] != unseen) continue;
                from[n] = c;
                queue.push_back(n);
                if (registry_.table().contains(patch_.regions[n], structure) == was_inside) continue;
                for (std::uint32_t step = c; step != no_cell; step = from[step])
                    patch_.regions[step] = patch_.regions[n];
                ++stats_.vertices_joined;
                return true;
            }
        }
        return start_component(vertex, structure);
    }

    // Nothing of the other side is near: the largest cell at the vertex starts a component of it.
    bool start_component(std::uint32_t vertex, std::uint32_t structure) {
        std::uint32_t largest = no_cell;
        double most = 0;
        for (const std::uint32_t c : stars_->at(vertex)) {
            const Cell& cell = patch_.cells[c];
            const double volume = signed_volume(patch_.points[cell[0]], patch_.points[cell[1]],
                                                patch_.points[cell[2]], patch_.points[cell[3]]);
            if (volume <= most) continue;
            most = volume;
            largest = c;
        }
        if (largest == no_cell) return false;
        patch_.regions[largest] = registry_.with_other_side(patch_.regions[largest], structure);
        ++stats_.vertices_joined;
        return true;
    }

    // Move 2 on every non-manifold edge whose ring shares no cell with one before it.
    void split_edges() {
        std::vector<Edge> edges;
        for (const std::uint32_t v : unsound_) {
            for (const std::uint32_t c : stars_->at(v)) {
                for (const std::uint32_t w : patch_.cells[c]) {
                    if (w != v) edges.push_back({std::min(v, w), std::max(v, w)});
                }
            }
        }
        std::sort(edges.begin(), edges.end());
        edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
        for (const Edge& edge : edges) split_edge(edge);
    }

    void split_edge(Edge edge) {
        std::uint32_t first = no_cell;
        for (const std::uint32_t c : stars_->at(edge[0])) {
            const Cell& cell = patch_.cells[c];
            if (std::find(cell.begin(), cell.end(), edge[1]) != cell.end()) {
                first = c;
                break;
            }
        }
        if (first == no_cell) return;
        const Ring ring = ring_of(patch_, first, edge);
        if (!ring.closed || touches_change(ring.cells)) return;
        std::optional<Arc> chosen;
        Region region = 0;
        for (const Body body : bodies_of(ring.cells)) {
            const std::vector<Arc> arcs = arcs_of(patch_, ring, registry_.table(), body);
            if (arcs.size() < 4) continue;
            const Arc arc = *std::min_element(arcs.begin(), arcs.end(), [](Arc a, Arc b) {
                return a.count != b.count ? a.count < b.count : a.begin < b.begin;
            });
            chosen = arc;
            region = patch_.regions[ring.cells[(arc.begin + ring.cells.size() - 1) % ring.cells.size()]];
            break;
        }
        if (chosen) cut_spindle(edge, ring, *chosen, region);
    }

    void cut_spindle(Edge edge, const Ring& ring, Arc arc, Region region) {
        const std::size_t n = ring.cells.size();
        const Vec3 middle = 0.5 * (patch_.points[edge[0]] + patch_.points[edge[1]]);
        const std::uint32_t first_new = static_cast<std::uint32_t>(patch_.points.size());
        for (const std::uint32_t v : ring.vertices) {
            patch_.points.push_back(middle + options_.spindle * (patch_.points[v] - middle));
        }
        Change added;
        for (std::size_t k = 0; k < n; ++k) {
            const std::uint32_t c = ring.vertices[k], d = ring.vertices[(k + 1) % n];
            const std::uint32_t p = first_new + static_cast<std::uint32_t>(k);
            const std::uint32_t q = first_new + static_cast<std::uint32_t>((k + 1) % n);
            const Region outer = patch_.regions[ring.cells[k]];
            const bool in_arc = (k + n - arc.begin) % n < arc.count;
            added.add({edge[0], edge[1], p, q}, in_arc ? region : outer);
            // The two pyramids over (p, q, d, c) share one diagonal.
            const bool from_p = p < q;
            const std::array<std::array<std::uint32_t, 3>, 2> halves =
                from_p ? std::array<std::array<std::uint32_t, 3>, 2>{{{p, d, q}, {p, c, d}}}
                       : std::array<std::array<std::uint32_t, 3>, 2>{{{q, p, c}, {q, c, d}}};
            for (const auto& [x, y, z] : halves) {
                added.add({edge[0], x, y, z}, outer);
                added.add({edge[1], x, y, z}, outer);
            }
        }
        if (!fits(added, ring.cells)) {
            patch_.points.resize(first_new);
            return;
        }
        commit(ring.cells, added, first_new);
        ++stats_.edges_split;
    }

    // Move 3 on every unsound vertex whose star shares no cell with one before it.
    void split_vertices() {
        std::vector<StarComponent> components;
        for (const std::uint32_t v : unsound_) {
            if (touches_change(stars_->at(v))) continue;
            analyzer_->excess_components(v, components);
            if (!components.empty()) cut_corner(v, components);
        }
    }

    // The star of v as facet-connected components on the two sides of a body; cells by position in the star.
    struct StarParts {
        std::vector<std::vector<std::uint32_t>> members;  // by component
        std::vector<std::uint8_t> inside;                 // by component
        std::vector<std::uint32_t> component;             // by cell
        std::vector<std::vector<std::uint32_t>> across;   // by cell: cells across its facets at v
        // By component: components of the other side, with repeats.
        std::vector<std::vector<std::uint32_t>> beside;
    };
    StarParts parts_of(std::uint32_t v, Body body) const {
        const auto star = stars_->at(v);
        StarParts parts;
        parts.component.assign(star.size(), no_cell);
        parts.across.resize(star.size());
        for (std::uint32_t n = 0; n < star.size(); ++n) {
            for (int i = 0; i < 4; ++i) {
                const std::uint32_t c = patch_.neighbors[star[n]][i];
                if (patch_.cells[star[n]][i] == v || c == no_cell) continue;
                parts.across[n].push_back(
                    static_cast<std::uint32_t>(std::lower_bound(star.begin(), star.end(), c) - star.begin()));
            }
        }
        const auto inside = [&](std::uint32_t n) {
            return body.holds(registry_.table(), patch_.regions[star[n]]);
        };
        for (std::uint32_t seed = 0; seed < star.size(); ++seed) {
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
        for (std::uint32_t n = 0; n < star.size(); ++n) {
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
    std::vector<Region> corner_regions(std::uint32_t v, const StarParts& parts, std::uint32_t main_in,
                                       std::uint32_t main_out) const {
        std::vector<Region> result;
        for (const std::uint32_t c : stars_->at(v)) result.push_back(patch_.regions[c]);
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
    std::array<std::size_t, 3> cost(std::uint32_t v, const std::vector<Region>& regions) const {
        const auto star = stars_->at(v);
        std::array<std::size_t, 3> sum{};
        const auto off_surface = [&](std::uint32_t structure, std::uint32_t other) {
            bool in = false, out = false;
            for (std::size_t n = 0; n < star.size(); ++n) {
                const Cell& cell = patch_.cells[star[n]];
                if (other != no_cell && std::find(cell.begin(), cell.end(), other) == cell.end()) continue;
                (registry_.table().contains(regions[n], structure) ? in : out) = true;
            }
            return other == no_cell ? !(in && out) : in != out;  // neither: not an edge of the mesh
        };
        for (const std::uint32_t structure : owners_.at(v)) sum[0] += off_surface(structure, no_cell);
        for (const ContourOwners::Subsegment& subsegment : subsegments_at(v))
            sum[1] += off_surface(subsegment.structure, subsegment.other);
        for (std::size_t n = 0; n < star.size(); ++n) sum[2] += regions[n] != patch_.regions[star[n]];
        return sum;
    }

    // With those that earlier corners left.
    std::vector<ContourOwners::Subsegment> subsegments_at(std::uint32_t v) const {
        std::vector<ContourOwners::Subsegment> subsegments(owners_.subsegments_at(v).begin(),
                                                           owners_.subsegments_at(v).end());
        for (const auto& [a, b, structure] : stats_.subsegments) {
            if (a == v) subsegments.push_back({b, structure});
            if (b == v) subsegments.push_back({a, structure});
        }
        return subsegments;
    }

    // The other way to make one disc: a component of a side that has several is joined to the nearest other
    // component of that side by a path of cells of the star, all given the region from which it starts.
    std::vector<Region> bridged_regions(std::uint32_t v, const StarComponent& start) const {
        const auto star = stars_->at(v);
        std::vector<Region> result;
        for (const std::uint32_t c : star) result.push_back(patch_.regions[c]);
        const auto position = [&](std::uint32_t c) {
            return std::lower_bound(star.begin(), star.end(), c) - star.begin();
        };
        constexpr std::uint32_t unseen = 0xFFFFFFFEu;
        std::vector<std::uint32_t> from(star.size(), unseen), queue = start.cells;
        for (const std::uint32_t c : start.cells) from[position(c)] = no_cell;
        for (std::size_t head = 0; head < queue.size(); ++head) {
            const std::uint32_t c = queue[head];
            for (int i = 0; i < 4; ++i) {
                const std::uint32_t n = patch_.neighbors[c][i];
                if (patch_.cells[c][i] == v || n == no_cell || from[position(n)] != unseen) continue;
                from[position(n)] = c;
                queue.push_back(n);
                if (start.body.holds(registry_.table(), patch_.regions[n]) != start.inside) continue;
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

    // The cheapest of all ways to make one disc of the body's surface at v.
    std::vector<Region> one_disc(std::uint32_t v, const std::vector<StarComponent>& components) const {
        std::vector<Region> best;
        std::array<std::size_t, 3> least{};
        const auto offer = [&](std::vector<Region> regions, bool path = false) {
            std::array<std::size_t, 3> price = cost(v, regions);
            if (path) price[2] = SIZE_MAX;  // a path may lead to another defect
            if (!best.empty() && price >= least) return;
            least = price;
            best = std::move(regions);
        };
        const StarParts parts = parts_of(v, components.front().body);
        for (std::uint32_t in = 0; in < parts.members.size(); ++in) {
            if (!parts.inside[in]) continue;
            std::vector<std::uint32_t> outs = parts.beside[in];
            std::sort(outs.begin(), outs.end());
            outs.erase(std::unique(outs.begin(), outs.end()), outs.end());
            for (const std::uint32_t out : outs) offer(corner_regions(v, parts, in, out));
        }
        for (const StarComponent& component : components) offer(bridged_regions(v, component), true);
        return best;
    }

    void cut_corner(std::uint32_t v, const std::vector<StarComponent>& components) {
        const std::vector<Region> corners = one_disc(v, components);
        const std::vector<std::uint32_t> star(stars_->at(v).begin(), stars_->at(v).end());
        std::vector<std::uint32_t> link;
        for (const std::uint32_t c : star) {
            for (const std::uint32_t u : patch_.cells[c]) {
                if (u != v) link.push_back(u);
            }
        }
        std::sort(link.begin(), link.end());
        link.erase(std::unique(link.begin(), link.end()), link.end());
        const std::uint32_t first_new = static_cast<std::uint32_t>(patch_.points.size());
        for (const std::uint32_t u : link) {
            patch_.points.push_back(patch_.points[v] +
                                    options_.corner * (patch_.points[u] - patch_.points[v]));
        }
        const auto cut = [&](std::uint32_t u) {
            return first_new +
                   static_cast<std::uint32_t>(std::lower_bound(link.begin(), link.end(), u) - link.begin());
        };
        Change added;
        for (std::size_t n = 0; n < star.size(); ++n) {
            std::array<std::uint32_t, 3> far{}, near{};
            int k = 0;
            for (const std::uint32_t u : patch_.cells[star[n]]) {
                if (u == v) continue;
                far[k] = u;
                near[k++] = cut(u);
            }
            added.add({v, near[0], near[1], near[2]}, corners[n]);
            add_prism(near, far, patch_.regions[star[n]], added);
        }
        if (!fits(added, star)) {
            patch_.points.resize(first_new);
            return;
        }
        commit(star, added, first_new);
        ++stats_.vertices_split;
        for (const ContourOwners::Subsegment& subsegment : subsegments_at(v)) {
            if (!std::binary_search(link.begin(), link.end(), subsegment.other)) continue;
            stats_.subsegments.push_back({v, cut(subsegment.other), subsegment.structure});
            stats_.subsegments.push_back({cut(subsegment.other), subsegment.other, subsegment.structure});
            stats_.on_segments.push_back(cut(subsegment.other));
        }
    }

    // Turns every cell positive. Whether the cells fill the place of those removed: not if one is flat, nor if
    // a new point was rounded to the other side of one nearly so, which then lies over its neighbours.
    bool fits(Change& added, std::span<const std::uint32_t> removed) const {
        for (Cell& cell : added.cells) {
            const int sign = orient3d(patch_.points[cell[0]], patch_.points[cell[1]], patch_.points[cell[2]],
                                      patch_.points[cell[3]]);
            if (sign == 0) return false;
            if (sign < 0) std::swap(cell[2], cell[3]);
        }
        std::vector<Cell> before;
        for (const std::uint32_t c : removed) before.push_back(patch_.cells[c]);
        const auto boundary = oriented_boundary(added.cells);
        return boundary && boundary == oriented_boundary(before);
    }

    // The regions of the cells, then their structures.
    std::vector<Body> bodies_of(const std::vector<std::uint32_t>& cells) const {
        std::vector<std::uint32_t> regions, structures;
        for (const std::uint32_t c : cells) {
            regions.push_back(patch_.regions[c]);
            const auto& members = registry_.table().members[patch_.regions[c]];
            structures.insert(structures.end(), members.begin(), members.end());
        }
        std::vector<Body> bodies;
        for (auto* list : {&regions, &structures}) {
            std::sort(list->begin(), list->end());
            list->erase(std::unique(list->begin(), list->end()), list->end());
            for (const std::uint32_t index : *list) bodies.push_back({list == &regions, index});
        }
        return bodies;
    }

    bool touches_change(std::span<const std::uint32_t> cells) const {
        return std::any_of(cells.begin(), cells.end(),
                           [&](std::uint32_t c) { return change_.removed[c] != 0; });
    }

    void commit(const std::vector<std::uint32_t>& removed, const Change& added, std::uint32_t first_new) {
        for (const std::uint32_t c : removed) change_.removed[c] = 1;
        change_.cells.insert(change_.cells.end(), added.cells.begin(), added.cells.end());
        change_.regions.insert(change_.regions.end(), added.regions.begin(), added.regions.end());
        stats_.points_added += patch_.points.size() - first_new;
        stats_.cells_added += added.cells.size() - removed.size();
        for (std::uint32_t v = first_new; v < patch_.points.size(); ++v) patch_.watched.push_back(v);
    }

    void apply_change() {
        std::size_t kept = 0;
        for (std::size_t c = 0; c < patch_.cells.size(); ++c) {
            if (change_.removed[c]) continue;
            patch_.cells[kept] = patch_.cells[c];
            patch_.regions[kept++] = patch_.regions[c];
        }
        patch_.cells.resize(kept);
        patch_.regions.resize(kept);
        patch_.cells.insert(patch_.cells.end(), change_.cells.begin(), change_.cells.end());
        patch_.regions.insert(patch_.regions.end(), change_.regions.begin(), change_.regions.end());
        patch_.rebuild_neighbors();
    }

    TetMesh& mesh_;
    const ContourOwners& owners_;
    RegionRegistry& registry_;
    SplitOptions options_;
    Patch patch_;
    Change change_;
    SplitStats stats_;
    std::optional<VertexStars> stars_;
    std::optional<StarAnalyzer> analyzer_;
    std::vector<std::uint32_t> unsound_;
};

}  // namespace

Result<SplitStats> split_unsound(TetMesh& mesh, const std::vector<std::uint32_t>& unsound,
                                 const ContourOwners& owners, RegionRegistry& registry,
                                 const SplitOptions& options, RunContext& context) {
    if (unsound.empty()) return SplitStats{};
    (void)context;
    Splitter splitter(mesh, owners, registry, options);
    return splitter.run(unsound);
}

}  // namespace anatomesh
