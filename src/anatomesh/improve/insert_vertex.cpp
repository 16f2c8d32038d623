#include <algorithm>
#include <array>

#include "anatomesh/improve/cell_shape.h"
#include "anatomesh/improve/operations.h"

namespace anatomesh {

namespace {

constexpr std::size_t most_facets = 60;
constexpr int rounds = 3;

// A hole in the mesh and the facets round it, each with the cell behind it.
class Hole {
  public:
    struct Facet {
        std::array<std::uint32_t, 3> v;  // counter-clockwise seen from outside the hole
        Region region;
        std::uint32_t beyond;
    };

    Hole(Workbench& bench, const EdgeRing& ring) : bench_(bench) {
        for (const std::uint32_t c : ring.cells) {
            cells_.push_back(c);
            for (int i = 0; i < 4; ++i) {
                const std::uint32_t opposite = bench.mesh.cell(c)[i];
                if (opposite == ring.a || opposite == ring.b) facets_.push_back(facet(c, i));
            }
        }
    }

    const std::vector<std::uint32_t>& cells() const { return cells_; }
    const std::vector<Facet>& facets() const { return facets_; }

    // Of its facets' corners.
    Vec3 centre() const {
        Vec3 sum{};
        for (const Facet& f : facets_) {
            for (const std::uint32_t v : f.v) sum = sum + bench_.mesh.point(v);
        }
        return (1.0 / (3.0 * static_cast<double>(facets_.size()))) * sum;
    }

    double sine(const Facet& f, Vec3 p) const {
        return least_sine(p, bench_.mesh.point(f.v[0]), bench_.mesh.point(f.v[1]), bench_.mesh.point(f.v[2]));
    }

    // Takes in the cells behind facets that make a bad cell with p, where their own facets make better ones.
    bool grow(Vec3 p, double goal) {
        bool grown = false;
        for (std::size_t n = 0; n < facets_.size() && facets_.size() < most_facets; ++n) {
            const Facet f = facets_[n];
            if (f.beyond == no_cell || bench_.mesh.region(f.beyond) != f.region) continue;
            const double own = sine(f, p);
            if (own >= goal) continue;
            if (!take(f.beyond, p, own)) continue;
            grown = true;
            n = static_cast<std::size_t>(-1);
        }
        return grown;
    }

    // Vertices that would lose all their cells must be free and off the interfaces.
    bool keeps_vertices() {
        std::vector<std::uint32_t> rim;
        for (const Facet& f : facets_) rim.insert(rim.end(), f.v.begin(), f.v.end());
        std::sort(rim.begin(), rim.end());
        for (const std::uint32_t c : cells_) {
            for (const std::uint32_t v : bench_.mesh.cell(c)) {
                if (!std::binary_search(rim.begin(), rim.end(), v) &&
                    (bench_.fixed(v) || bench_.mesh.vertex_on_interface(v))) {
                    return false;
                }
            }
        }
        return true;
    }

  private:
    Facet facet(std::uint32_t c, int i) const {
        const Cell& cell = bench_.mesh.cell(c);
        const auto& f = facet_vertices[i];
        return {{cell[f[0]], cell[f[1]], cell[f[2]]}, bench_.mesh.region(c), bench_.mesh.neighbor(c, i)};
    }

    bool take(std::uint32_t c, Vec3 p, double own) {
        // Facets of an interface stay.
        for (const Facet& f : facets_) {
            if (f.beyond == c && f.region != bench_.mesh.region(c)) return false;
        }
        for (int i = 0; i < 4; ++i) {
            const std::uint32_t n = bench_.mesh.neighbor(c, i);
            if (std::find(cells_.begin(), cells_.end(), n) != cells_.end()) continue;
            if (!(sine(facet(c, i), p) > own)) return false;
        }
        // The facets between the cell and the hole go.
        std::erase_if(facets_, [&](const Facet& f) { return f.beyond == c; });
        for (int i = 0; i < 4; ++i) {
            const std::uint32_t n = bench_.mesh.neighbor(c, i);
            if (std::find(cells_.begin(), cells_.end(), n) == cells_.end()) facets_.push_back(facet(c, i));
        }
        cells_.push_back(c);
        return true;
    }

    Workbench& bench_;
    std::vector<std::uint32_t> cells_;
    std::vector<Facet> facets_;
};

// The new vertex of an edge on a surface between two regions: on the field's interface, its facets near that.
class OnSurface {
  public:
    OnSurface(Workbench& bench, std::array<std::uint32_t, 2> across)
        : bench_(bench), a_(bench.ring.a), b_(bench.ring.b), across_(across) {
        const Vec3 pa = bench.mesh.point(a_), pb = bench.mesh.point(b_);
        for (const std::uint32_t v : across_) {
            before_ = std::max(before_, bench.facet_distance(pa, pb, bench.mesh.point(v)));
        }
        reach_ = 0.3 * length(pb - pa);
        const Vec3 pc = bench.mesh.point(across_[0]), pd = bench.mesh.point(across_[1]);
        normal = normalized(normalized(cross(pb - pa, pc - pa)) + normalized(cross(pd - pa, pb - pa)));
    }

    bool operator()(Vec3& q) const {
        const auto onto = bench_.probe.project(q, reach_, 0.1 * bench_.options.tolerance_mm);
        if (onto) q = *onto;
        if (!onto && bench_.probe.distance(q) > 0.5 * bench_.options.tolerance_mm) return false;
        const Vec3 pa = bench_.mesh.point(a_), pb = bench_.mesh.point(b_);
        double sign = 1;
        for (const std::uint32_t v : across_) {
            const Vec3 pv = bench_.mesh.point(v);
            for (const auto& [s, t] : {std::array<Vec3, 2>{pa, q}, std::array<Vec3, 2>{q, pb}}) {
                const Vec3 area = sign * cross(t - s, pv - s);
                if (!(dot(area, normal) > 0.5 * length(area))) return false;
                if (bench_.facet_distance(s, t, pv) > std::max(before_, bench_.options.max_deviation_mm))
                    return false;
            }
            sign = -sign;
        }
        return true;
    }

    Vec3 normal;

  private:
    Workbench& bench_;
    std::uint32_t a_, b_;
    std::array<std::uint32_t, 2> across_;
    double before_ = 0, reach_ = 0;
};

template <class Adjust>
bool fill(Workbench& bench, Hole& hole, Vec3 p, Vec3 normal, Adjust&& adjust) {
    if (!adjust(p)) return false;
    Bar bar;
    double reached = 0;
    for (int round = 0;; ++round) {
        bar = bench.bar_of(hole.cells());
        bench.local.reset(bench.needed_outside_sine(bar), bench.allowed_squared_ratio(bar));
        double value = 1;
        for (const Hole::Facet& f : hole.facets()) {
            bench.local.add(bench.mesh.point(f.v[0]), bench.mesh.point(f.v[1]), bench.mesh.point(f.v[2]),
                            f.region != 0);
            if (f.region != 0) value = std::min(value, hole.sine(f, p));
        }
        reached = bench.local.ascend(p, value, bench.goal, normal, adjust);
        if (reached >= bench.goal || round == rounds || !hole.grow(p, bench.goal)) break;
    }
    if (reached < bench.needed_sine(bar) || bench.local.worst(p, reached) < reached || !hole.keeps_vertices())
        return false;
    const std::uint32_t v = bench.add_point(p);
    bench.cells.clear();
    bench.regions.clear();
    for (const Hole::Facet& f : hole.facets()) {
        bench.cells.push_back({v, f.v[0], f.v[1], f.v[2]});
        bench.regions.push_back(f.region);
    }
    return bench.commit(hole.cells(), bench.cells, bench.regions);
}

}  // namespace

bool insert_vertex(Workbench& bench, std::uint32_t cell, int e) {
    bench.mesh.ring(cell, e, bench.ring);
    if (!bench.ring.closed) return false;
    std::array<std::uint32_t, 2> across{};
    int changes = 0;
    for (std::size_t n = 0; n < bench.ring.cells.size(); ++n) {
        const std::uint32_t before = bench.ring.cells[n == 0 ? bench.ring.cells.size() - 1 : n - 1];
        if (bench.mesh.region(bench.ring.cells[n]) == bench.mesh.region(before)) continue;
        if (changes < 2) across[static_cast<std::size_t>(changes)] = bench.ring.ring[n];
        ++changes;
    }
    if (changes > 2 || (changes == 2 && bench.fixed_edge(bench.ring.a, bench.ring.b))) return false;
    const Vec3 middle = 0.5 * (bench.mesh.point(bench.ring.a) + bench.mesh.point(bench.ring.b));
    Hole hole(bench, bench.ring);
    bool done = false;
    if (changes == 2) {
        const OnSurface surface(bench, across);
        done = fill(bench, hole, middle, surface.normal, surface);
    } else {
        const auto anywhere = [](Vec3&) { return true; };
        done = fill(bench, hole, middle, {}, anywhere);
        if (!done) {
            // Where the edge lies in a flat side of the hole, its middle is no place to start from.
            Hole again(bench, bench.ring);
            done = fill(bench, again, again.centre(), {}, anywhere);
        }
    }
    bench.stats.vertices_inserted += done;
    return done;
}

}  // namespace anatomesh
