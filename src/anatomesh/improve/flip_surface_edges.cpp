#include "anatomesh/improve/flip_surface_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "anatomesh/base/parallel.h"
#include "anatomesh/improve/operations.h"

namespace anatomesh {

namespace {

constexpr std::uint32_t no_facet = 0xFFFFFFFFu;

// Between two regions; counter-clockwise seen from the one with the smaller number.
struct Facet {
    std::array<std::uint32_t, 3> corners{};
    std::array<std::uint32_t, 3> across{};  // the facet beyond the edge opposite a corner; none at a junction
    std::uint32_t cell = 0;                 // one behind it, unless a flip has taken that away
    Region behind = 0, before = 0;
    Vec3 normal;
};

// Of unit vectors, in radians, to 7e-5: Abramowitz and Stegun, Handbook of Mathematical Functions, 4.4.45.
double angle_between(Vec3 n, Vec3 m) {
    const double cosine = dot(n, m), x = std::min(std::abs(cosine), 1.0);
    const double angle = std::sqrt(1 - x) * (1.5707288 + x * (-0.2121144 + x * (0.0742610 - 0.0187293 * x)));
    return cosine < 0 ? std::numbers::pi - angle : angle;
}

class Flipper {
  public:
    Flipper(Workbench& bench, const FlipOptions& options, int threads)
        : bench_(bench), options_(options), threads_(threads) {
        collect();
        link();
    }

    void run(std::vector<std::uint32_t>& changed) {
        waits_.assign(facets_.size(), 0);
        gains_.assign(facets_.size(), 0);
        fails_.assign(facets_.size(), 0);
        std::vector<std::uint32_t> work(facets_.size());
        for (std::uint32_t f = 0; f < work.size(); ++f) work[f] = f;
        for (int round = 0; round < options_.rounds && !work.empty(); ++round) {
            for (const std::uint32_t f : work) waits_[f] = 1;
            touched_.assign(bench_.mesh.point_count(), 0);
            measure_gains(work);
            std::vector<std::uint32_t> flipped;
            for (std::size_t n = 0; n < work.size(); ++n) {
                const std::uint32_t f = work[n];
                prefetch(work, n);
                waits_[f] = 0;
                for (int k = 0; k < 3; ++k) {
                    const std::uint32_t g = facets_[f].across[k];
                    if (g == no_facet || waits_[g] || !(gains_[f] >> k & 1) || known_to_fail(f, k) ||
                        !flip(f, k, changed))
                        continue;
                    expect_gains_round(f, g);
                    flipped.push_back(f);
                    flipped.push_back(g);
                    break;
                }
            }
            work = with_neighbors(flipped);
        }
    }

  private:
    // The four corners at an edge: facets (a, b, c) and (b, a, d), to become (a, d, c) and (d, b, c).
    struct Quad {
        std::uint32_t f, g;  // the facets
        int k, j;            // the places of c in f and of d in g
        std::uint32_t a, b, c, d;
    };

    void prefetch_beside(std::uint32_t f) const {
        for (const std::uint32_t g : facets_[f].across) {
            if (g != no_facet) __builtin_prefetch(&facets_[g]);
        }
    }

    // One facet in a few is flipped: what that reads is brought into the cache before its turn comes.
    void prefetch(const std::vector<std::uint32_t>& work, std::size_t n) const {
        constexpr std::size_t ahead = 16;
        const auto cell_at = [&](std::size_t m) {
            return m < work.size() && gains_[work[m]] != 0 ? facets_[work[m]].cell : no_cell;
        };
        if (const std::uint32_t c = cell_at(n + 2 * ahead); c != no_cell) bench_.mesh.prefetch(c);
        if (const std::uint32_t c = cell_at(n + ahead); c != no_cell) bench_.mesh.prefetch_round(c);
    }

    Vec3 normal(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
        const Vec3 p = bench_.mesh.point(a), n = cross(bench_.mesh.point(b) - p, bench_.mesh.point(c) - p);
        const double size = length(n);
        return size > 0 ? (1 / size) * n : Vec3{};
    }

    void collect() {
        const EditMesh& mesh = bench_.mesh;
        const auto add_facets_of = [&](std::uint32_t c, std::vector<Facet>& facets) {
            if (!mesh.alive(c) || mesh.region(c) == 0) return;
            for (int i = 0; i < 4; ++i) {
                const std::uint32_t other = mesh.neighbor(c, i);
                if (other == no_cell || mesh.region(other) >= mesh.region(c)) continue;
                Facet facet;
                for (int n = 0; n < 3; ++n) facet.corners[n] = mesh.cell(c)[facet_vertices[i][n]];
                facet.cell = c;
                facet.behind = mesh.region(c);
                facet.before = mesh.region(other);
                facet.normal = normal(facet.corners[0], facet.corners[1], facet.corners[2]);
                facets.push_back(facet);
            }
        };
        facets_ =
            parallel_collect<Facet>(mesh.cell_count(), 16384, threads_,
                                    [&](std::size_t first, std::size_t last, std::vector<Facet>& facets) {
                                        for (std::size_t c = first; c < last; ++c)
                                            add_facets_of(static_cast<std::uint32_t>(c), facets);
                                    });
    }

    // Which edges of the facets would gain by a flip as things are; and, while there are several threads to
    // look, which of these cannot be flipped: what happens to the mesh is the same without.
    void measure_gains(const std::vector<std::uint32_t>& work) {
        parallel_for(work.size(), 1024, threads_, [&](std::size_t first, std::size_t last) {
            std::optional<Workbench> scout;
            if (threads_ > 1) scout.emplace(bench_).scouts = true;
            for (std::size_t n = first; n < last; ++n) {
                if (n + cells_ahead < last) prefetch_beside(work[n + cells_ahead]);
                const std::uint32_t f = work[n];
                std::uint8_t gains = 0, fails = 0;
                for (int k = 0; k < 3; ++k) {
                    const std::uint32_t g = facets_[f].across[k];
                    // Of two facets in the work, the later one asks.
                    if (g == no_facet || (g > f && waits_[g])) continue;
                    const Quad q = quad(f, k);
                    if (!gains_enough(q, normal(q.a, q.d, q.c), normal(q.d, q.b, q.c))) continue;
                    gains = static_cast<std::uint8_t>(gains | 1 << k);
                    if (scout && !flip_cells(*scout, q)) fails = static_cast<std::uint8_t>(fails | 1 << k);
                }
                gains_[f] = gains;
                fails_[f] = fails;
            }
        });
    }

    // Whether a scout found that the cells do not let an edge of f be flipped, and none round it has changed
    // since.
    bool known_to_fail(std::uint32_t f, int k) const {
        const auto& corners = facets_[f].corners;
        return fails_[f] >> k & 1 && !(touched_[corners[(k + 1) % 3]] && touched_[corners[(k + 2) % 3]]);
    }

    // After a flip of f and g, what was measured for the facets up to two further on may not hold.
    void expect_gains_round(std::uint32_t f, std::uint32_t g) {
        constexpr std::uint8_t all = 7;
        for (const std::uint32_t flipped : {f, g}) {
            gains_[flipped] = all;
            for (const std::uint32_t near : facets_[flipped].across) {
                if (near == no_facet) continue;
                gains_[near] = all;
                for (const std::uint32_t far : facets_[near].across) {
                    if (far != no_facet) gains_[far] = all;
                }
            }
        }
    }

    // Joins the facets of each edge that has just two.
    void link() {
        std::vector<std::uint32_t> start(bench_.mesh.point_count() + 1, 0);
        const auto least_end = [&](const Facet& facet, int k) {
            return std::min(facet.corners[(k + 1) % 3], facet.corners[(k + 2) % 3]);
        };
        for (const Facet& facet : facets_) {
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

    std::vector<std::uint32_t> with_neighbors(const std::vector<std::uint32_t>& changed) const {
        std::vector<std::uint32_t> all;
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
        const Facet &f = facets_[q.f], &g = facets_[q.g];
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

    bool gains_enough(const Quad& q, Vec3 n, Vec3 m) const {
        return gain(q, n, m) >= options_.least_gain_degrees * std::numbers::pi / 180;
    }

    bool flip(std::uint32_t f, int k, std::vector<std::uint32_t>& changed) {
        const Quad q = quad(f, k);
        const Vec3 n = normal(q.a, q.d, q.c), m = normal(q.d, q.b, q.c);
        if (!gains_enough(q, n, m) || !flip_cells(bench_, q)) return false;
        changed.insert(changed.end(), bench_.changed.begin(), bench_.changed.end());
        for (const std::uint32_t c : bench_.changed) {
            for (const std::uint32_t v : bench_.mesh.cell(c)) touched_[v] = 1;
        }
        replace(q, n, m);
        return true;
    }

    // The flip in the cells of the bench, or, on a scout's, whether it may succeed.
    bool flip_cells(Workbench& bench, const Quad& q) {
        if (bench.fixed_edge(q.a, q.b)) return false;
        const auto edge = cell_edge(bench, facets_[q.f], q.a, q.b);
        return edge && flip_edge(bench, edge->first, edge->second, options_.good_sine);
    }

    // A cell behind the facet and its edge ab.
    static std::optional<std::pair<std::uint32_t, int>> cell_edge(Workbench& bench, Facet& facet,
                                                                  std::uint32_t a, std::uint32_t b) {
        const auto behind = [&](std::uint32_t c) {
            if (!bench.mesh.alive(c) || bench.mesh.region(c) != facet.behind) return false;
            const Cell& cell = bench.mesh.cell(c);
            return std::all_of(facet.corners.begin(), facet.corners.end(), [&](std::uint32_t v) {
                return std::find(cell.begin(), cell.end(), v) != cell.end();
            });
        };
        if (!behind(facet.cell)) {
            if (bench.scouts) {
                bench.mesh.shared_star(a, bench.star);
            } else {
                bench.mesh.star(a, bench.star);
            }
            const auto found = std::find_if(bench.star.begin(), bench.star.end(), behind);
            if (found == bench.star.end()) return std::nullopt;
            facet.cell = *found;
        }
        const Cell& cell = bench.mesh.cell(facet.cell);
        for (int e = 0; e < 6; ++e) {
            const std::uint32_t u = cell[cell_edges[e][0]], v = cell[cell_edges[e][1]];
            if ((u == a && v == b) || (u == b && v == a)) return std::pair{facet.cell, e};
        }
        return std::nullopt;
    }

    // The facets f and g become (a, d, c) and (d, b, c).
    void replace(const Quad& q, Vec3 n, Vec3 m) {
        Facet &f = facets_[q.f], &g = facets_[q.g];
        const std::uint32_t beyond_bc = f.across[(q.k + 1) % 3], beyond_ca = f.across[(q.k + 2) % 3],
                            beyond_ad = g.across[(q.j + 1) % 3], beyond_db = g.across[(q.j + 2) % 3];
        f.corners = {q.a, q.d, q.c};
        f.across = {q.g, beyond_ca, beyond_ad};
        f.normal = n;
        g.corners = {q.d, q.b, q.c};
        g.across = {beyond_bc, q.f, beyond_db};
        g.normal = m;
        if (beyond_ad != no_facet)
            *std::find(facets_[beyond_ad].across.begin(), facets_[beyond_ad].across.end(), q.g) = q.f;
        if (beyond_bc != no_facet)
            *std::find(facets_[beyond_bc].across.begin(), facets_[beyond_bc].across.end(), q.f) = q.g;
    }

    Workbench& bench_;
    FlipOptions options_;
    int threads_;
    std::vector<Facet> facets_;
    std::vector<std::uint8_t> gains_;  // by facet: a bit for each edge whose flip may gain
    std::vector<std::uint8_t> fails_;  // by facet: a bit for each edge that a scout could not flip
    std::vector<std::uint8_t> touched_;  // by vertex, since the scouts: a cell at it has changed
    std::vector<std::uint8_t> waits_;  // by facet: its turn in this round is still to come
};

}  // namespace

void flip_surface_edges(Workbench& bench, const FlipOptions& options, int threads,
                        std::vector<std::uint32_t>& changed) {
    Flipper(bench, options, threads).run(changed);
}

}  // namespace anatomesh
