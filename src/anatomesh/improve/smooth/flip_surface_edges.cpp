#include "anatomesh/improve/smooth/flip_surface_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "anatomesh/base/parallel.h"
#include "anatomesh/improve/operations/operations.h"

namespace anatomesh {

namespace {

// It stands for no facet across an edge. [1; the largest index; D]
constexpr std::uint32_t no_facet = 0xFFFFFFFFu;

// A facet between two regions, counter-clockwise seen from the one with the smaller number.
struct SurfaceFacet {
    std::array<std::uint32_t, 3> corners{};
    std::array<std::uint32_t, 3> across{};  // the facet beyond the edge opposite a corner; none at a junction
    std::uint32_t cell = 0;                 // one behind it, unless a flip has taken that away
    Region behind = 0, before = 0;
    Vec3 normal;
};

// The angle between unit vectors, in radians, to 7e-5: Abramowitz and Stegun, Handbook of Mathematical
// Functions, 4.4.45.
double angle_between(Vec3 n, Vec3 m) {
    const double cosine = dot(n, m), x = std::min(std::abs(cosine), 1.0);
    const double angle = std::sqrt(1 - x) * (1.5707288 + x * (-0.2121144 + x * (0.0742610 - 0.0187293 * x)));
    return cosine < 0 ? std::numbers::pi - angle : angle;
}

class Flipper {
  public:
    Flipper(EditContext& edit, const FlipOptions& options, int threads)
        : edit_(edit), options_(options), threads_(threads) {
        collect();
        link();
    }

    void run(std::vector<std::uint32_t>& changed) {
        waits_.assign(facets_.size(), 0);
        std::vector<std::uint32_t> work(facets_.size());
        for (std::uint32_t f = 0; f < work.size(); ++f) work[f] = f;
        for (int round = 0; round < options_.rounds && !work.empty(); ++round) {
            std::vector<Flip> flips = find_flips(work);
            std::vector<CellExchange> exchanges;
            exchanges.reserve(flips.size());
            for (Flip& flip : flips) exchanges.push_back(std::move(flip.cells));
            const std::vector<std::uint8_t> done = edit_.mesh.replace_apart(exchanges, threads_);
            std::vector<std::uint32_t> flipped, left;
            for (std::size_t n = 0; n < flips.size(); ++n) {
                const Quad& q = flips[n].quad;
                if (!done[n]) {
                    left.push_back(q.f);
                    continue;
                }
                replace(flips[n], exchanges[n]);
                flipped.insert(flipped.end(), {q.f, q.g});
                changed.insert(changed.end(), exchanges[n].slots.begin(), exchanges[n].slots.end());
                ++edit_.stats.operations.surface_edges_smoothed;
            }
            work = with_neighbors(flipped, std::move(left));
        }
    }

  private:
    // The four corners at an edge: facets (a, b, c) and (b, a, d), to become (a, d, c) and (d, b, c).
    struct Quad {
        std::uint32_t f, g;  // the facets
        int k, j;            // the places of c in f and of d in g
        std::uint32_t a, b, c, d;
    };

    struct Flip {
        Quad quad;
        Vec3 n, m;    // normals of the new facets
        double gain;  // see gain()
        CellExchange cells;
    };

    void prefetch_beside(std::uint32_t f) const {
        for (const std::uint32_t g : facets_[f].across) {
            if (g != no_facet) __builtin_prefetch(&facets_[g]);
        }
    }

    Vec3 normal(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
        const Vec3 p = edit_.mesh.point(a), n = cross(edit_.mesh.point(b) - p, edit_.mesh.point(c) - p);
        const double size = length(n);
        return size > 0 ? (1 / size) * n : Vec3{};
    }

    void collect() {
        const EditMesh& mesh = edit_.mesh;
        const auto add_facets_of = [&](std::uint32_t c, std::vector<SurfaceFacet>& facets) {
            if (!mesh.alive(c) || mesh.region(c) == 0) return;
            for (int i = 0; i < 4; ++i) {
                const std::uint32_t other = mesh.neighbor(c, i);
                if (other == no_cell || mesh.region(other) >= mesh.region(c)) continue;
                SurfaceFacet facet;
                for (int n = 0; n < 3; ++n) facet.corners[n] = mesh.cell(c)[facet_vertices[i][n]];
                facet.cell = c;
                facet.behind = mesh.region(c);
                facet.before = mesh.region(other);
                facet.normal = normal(facet.corners[0], facet.corners[1], facet.corners[2]);
                facets.push_back(facet);
            }
        };
        facets_ = parallel_collect<SurfaceFacet>(
            mesh.cell_count(), 16384, threads_,
            [&](std::size_t first, std::size_t last, std::vector<SurfaceFacet>& facets) {
                for (std::size_t c = first; c < last; ++c)
                    add_facets_of(static_cast<std::uint32_t>(c), facets);
            });
    }

    // The flips of the facets' edges that gain and that the cells allow, the largest gain first.
    std::vector<Flip> find_flips(const std::vector<std::uint32_t>& work) {
        for (const std::uint32_t f : work) waits_[f] = 1;
        std::vector<Flip> flips = parallel_collect<Flip>(
            work.size(), 512, threads_, [&](std::size_t first, std::size_t last, std::vector<Flip>& found) {
                EditContext local_edit = edit_;
                local_edit.speculation.active = true;
                for (std::size_t n = first; n < last; ++n) {
                    if (n + cells_ahead < last) prefetch_beside(work[n + cells_ahead]);
                    for (int k = 0; k < 3; ++k) {
                        const std::uint32_t f = work[n], g = facets_[f].across[k];
                        // Of two facets in the work, the later one asks.
                        if (g != no_facet && !(g > f && waits_[g])) add_flip(local_edit, quad(f, k), found);
                    }
                }
            });
        for (const std::uint32_t f : work) waits_[f] = 0;
        std::sort(flips.begin(), flips.end(), [](const Flip& x, const Flip& y) {
            if (x.gain != y.gain) return x.gain > y.gain;
            return x.quad.f != y.quad.f ? x.quad.f < y.quad.f : x.quad.k < y.quad.k;
        });
        return flips;
    }

    void add_flip(EditContext& local_edit, const Quad& q, std::vector<Flip>& found) {
        const Vec3 n = normal(q.a, q.d, q.c), m = normal(q.d, q.b, q.c);
        const double gained = gain(q, n, m);
        if (!(gained >= options_.least_gain_degrees * std::numbers::pi / 180) || !flip_cells(local_edit, q))
            return;
        found.push_back({q, n, m, gained, std::move(local_edit.speculation.proposal.cells)});
    }

    // Joins the facets of each edge that has just two.
    void link() {
        std::vector<std::uint32_t> start(edit_.mesh.point_count() + 1, 0);
        const auto least_end = [&](const SurfaceFacet& facet, int k) {
            return std::min(facet.corners[(k + 1) % 3], facet.corners[(k + 2) % 3]);
        };
        for (const SurfaceFacet& facet : facets_) {
            for (int k = 0; k < 3; ++k) ++start[least_end(facet, k) + 1];
        }
        for (std::size_t v = 0; v + 1 < start.size(); ++v) start[v + 1] += start[v];
        struct Side {
            std::uint32_t end, facet;  // the larger end of the edge
            int k;
        };
        std::vector<Side> sides(start.back());
        std::vector<std::uint32_t> place(start.begin(), start.end() - 1);
        for (std::uint32_t f = 0; f < facets_.size(); ++f) {
            facets_[f].across.fill(no_facet);
            for (int k = 0; k < 3; ++k) {
                const std::uint32_t end =
                    std::max(facets_[f].corners[(k + 1) % 3], facets_[f].corners[(k + 2) % 3]);
                sides[place[least_end(facets_[f], k)]++] = {end, f, k};
            }
        }
        // Each edge is at one vertex, so no two threads have the same place.
        const auto join_at = [&](std::size_t v) {
            const auto first = sides.begin() + start[v], last = sides.begin() + start[v + 1];
            std::sort(first, last, [](const Side& x, const Side& y) {
                return x.end != y.end ? x.end < y.end : x.facet < y.facet;
            });
            for (auto at = first; at != last;) {
                const auto after =
                    std::find_if(at, last, [&](const Side& side) { return side.end != at->end; });
                if (after - at == 2) {
                    facets_[at[0].facet].across[at[0].k] = at[1].facet;
                    facets_[at[1].facet].across[at[1].k] = at[0].facet;
                }
                at = after;
            }
        };
        parallel_for(start.size() - 1, 16384, threads_, [&](std::size_t first, std::size_t last) {
            for (std::size_t v = first; v < last; ++v) join_at(v);
        });
    }

    // The facets, their neighbours, and those that were left.
    std::vector<std::uint32_t> with_neighbors(const std::vector<std::uint32_t>& changed,
                                              std::vector<std::uint32_t> left) const {
        std::vector<std::uint32_t> all = std::move(left);
        for (const std::uint32_t f : changed) {
            all.push_back(f);
            for (const std::uint32_t g : facets_[f].across) {
                if (g != no_facet) all.push_back(g);
            }
        }
        std::sort(all.begin(), all.end());
        all.erase(std::unique(all.begin(), all.end()), all.end());
        return all;
    }

    Quad quad(std::uint32_t f, int k) const {
        Quad q{f, facets_[f].across[k], k, 0, 0, 0, 0, 0};
        while (facets_[q.g].across[q.j] != f) ++q.j;
        q.a = facets_[f].corners[(k + 1) % 3];
        q.b = facets_[f].corners[(k + 2) % 3];
        q.c = facets_[f].corners[k];
        q.d = facets_[q.g].corners[q.j];
        return q;
    }

    // By how much the angles at the two facets fall, in radians; n and m are the new ones' normals.
    double gain(const Quad& q, Vec3 n, Vec3 m) const {
        const SurfaceFacet &f = facets_[q.f], &g = facets_[q.g];
        double sum = angle_between(f.normal, g.normal) - angle_between(n, m);
        const auto add = [&](std::uint32_t beyond, Vec3 now, Vec3 then) {
            if (beyond == no_facet) return;
            sum += angle_between(facets_[beyond].normal, now) - angle_between(facets_[beyond].normal, then);
        };
        add(f.across[(q.k + 1) % 3], f.normal, m);
        add(f.across[(q.k + 2) % 3], f.normal, n);
        add(g.across[(q.j + 1) % 3], g.normal, n);
        add(g.across[(q.j + 2) % 3], g.normal, m);
        return sum;
    }

    // Whether the cells let the edge be flipped; the local context has the new ones then.
    bool flip_cells(EditContext& local_edit, const Quad& q) {
        if (local_edit.constraints.fixed_edge(q.a, q.b)) return false;
        const auto edge = cell_edge(local_edit, facets_[q.f], q.a, q.b);
        return edge && flip_edge(local_edit, edge->first, edge->second, options_.good_sine);
    }

    static bool has_facet(const Cell& cell, const SurfaceFacet& facet) {
        return std::all_of(facet.corners.begin(), facet.corners.end(), [&](std::uint32_t v) {
            return std::find(cell.begin(), cell.end(), v) != cell.end();
        });
    }

    // A cell behind the facet and its edge ab.
    static std::optional<std::pair<std::uint32_t, int>> cell_edge(EditContext& local_edit,
                                                                  SurfaceFacet& facet, std::uint32_t a,
                                                                  std::uint32_t b) {
        const auto is_behind = [&](std::uint32_t c) {
            return local_edit.mesh.alive(c) && local_edit.mesh.region(c) == facet.behind &&
                   has_facet(local_edit.mesh.cell(c), facet);
        };
        if (!is_behind(facet.cell)) {
            local_edit.mesh.shared_star(a, local_edit.star);
            const auto found = std::find_if(local_edit.star.begin(), local_edit.star.end(), is_behind);
            if (found == local_edit.star.end()) return std::nullopt;
            facet.cell = *found;
        }
        const Cell& cell = local_edit.mesh.cell(facet.cell);
        for (int e = 0; e < 6; ++e) {
            const std::uint32_t u = cell[cell_edges[e][0]], v = cell[cell_edges[e][1]];
            if ((u == a && v == b) || (u == b && v == a)) return std::pair{facet.cell, e};
        }
        return std::nullopt;
    }

    // The facets f and g become (a, d, c) and (d, b, c).
    void replace(const Flip& flip, const CellExchange& cells) {
        const Quad& q = flip.quad;
        SurfaceFacet &f = facets_[q.f], &g = facets_[q.g];
        const std::uint32_t beyond_bc = f.across[(q.k + 1) % 3], beyond_ca = f.across[(q.k + 2) % 3],
                            beyond_ad = g.across[(q.j + 1) % 3], beyond_db = g.across[(q.j + 2) % 3];
        f.corners = {q.a, q.d, q.c};
        f.across = {q.g, beyond_ca, beyond_ad};
        f.normal = flip.n;
        g.corners = {q.d, q.b, q.c};
        g.across = {beyond_bc, q.f, beyond_db};
        g.normal = flip.m;
        for (std::size_t n = 0; n < cells.added.size(); ++n) {
            for (SurfaceFacet* facet : {&f, &g}) {
                if (cells.regions[n] == facet->behind && has_facet(cells.added[n], *facet))
                    facet->cell = cells.slots[n];
            }
        }
        if (beyond_ad != no_facet)
            *std::find(facets_[beyond_ad].across.begin(), facets_[beyond_ad].across.end(), q.g) = q.f;
        if (beyond_bc != no_facet)
            *std::find(facets_[beyond_bc].across.begin(), facets_[beyond_bc].across.end(), q.f) = q.g;
    }

    EditContext& edit_;
    FlipOptions options_;
    int threads_;
    std::vector<SurfaceFacet> facets_;
    std::vector<std::uint8_t> waits_;  // by facet: it is in the work
};

}  // namespace

void flip_surface_edges(EditContext& edit, const FlipOptions& options, int threads,
                        std::vector<std::uint32_t>& changed) {
    Flipper(edit, options, threads).run(changed);
}

}  // namespace anatomesh
