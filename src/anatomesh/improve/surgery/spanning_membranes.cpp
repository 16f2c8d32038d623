#include "anatomesh/improve/surgery/spanning_membranes.h"

#include <map>
#include <optional>
#include <queue>
#include <set>
#include <utility>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/improve/core/surface_incidence.h"

namespace anatomesh {

namespace {

constexpr std::size_t most_subsegments = 50;  // of a chain [subsegments; > 0; B]
constexpr std::size_t most_facets = 8;  // of a membrane, beside one for each subsegment [facets; > 0; B]
constexpr std::size_t most_looked_at = 4000;  // that are grown [membranes; > 0; B]
constexpr std::size_t most_membranes = 16;    // for a chain [membranes; > 0; B]
constexpr std::size_t most_across = 6;        // on one side of a structure [membranes; > 0; B]
// Area of the facets that an edge off the surface still needs, in squares of its length: an equilateral
// triangle. [1; > 0; D]
constexpr double edge_price = 0.43;
// Price of a facet where the field has the side of the chain, in areas.
// [1; >= 1; M 2026-11 fetal brain, body labels, abdomen]
constexpr double wrong_side = 5;

struct Dearer {
    bool operator()(const Membrane& x, const Membrane& y) const {
        const double here = x.price + x.to_come, there = y.price + y.to_come;
        return here != there ? here > there : x.facets > y.facets;
    }
};

// All chains of subsegments beside their surfaces that begin and end on them.
class ChainSearch {
  public:
    ChainSearch(EditContext& edit, const ContourOwners& owners) : owners_(owners), incidence_(edit) {}

    // `subsegments`: those that may be.
    std::vector<Chain> run(std::span<const std::array<std::uint32_t, 3>> subsegments) {
        std::vector<std::array<std::uint32_t, 3>> ends;
        for (const auto& [a, b, structure] : subsegments) {
            ends.push_back({a, b, structure});
            ends.push_back({b, a, structure});
        }
        sort_distinct(ends);
        for (const auto& [v, other, structure] : ends) {
            if (incidence_.beside_surface(v, other, structure) && incidence_.on_surface(v, structure))
                follow(v, {other, structure});
        }
        return std::move(chains_);
    }

  private:
    void follow(std::uint32_t first, ContourOwners::Subsegment subsegment) {
        Chain chain{{first, subsegment.other}, subsegment.structure};
        while (!incidence_.on_surface(chain.vertices.back(), subsegment.structure)) {
            const std::uint32_t at = chain.vertices.back(), from = chain.vertices[chain.vertices.size() - 2];
            const auto subsegments = owners_.subsegments_at(at);
            const auto next = std::find_if(
                subsegments.begin(), subsegments.end(), [&](const ContourOwners::Subsegment& other) {
                    return other.structure == subsegment.structure && other.other != from &&
                           incidence_.beside_surface(at, other.other, subsegment.structure);
                });
            if (next == subsegments.end() || chain.vertices.size() > most_subsegments) return;
            chain.vertices.push_back(next->other);
        }
        // From the other end it is found too.
        if (chain.vertices.front() < chain.vertices.back()) chains_.push_back(std::move(chain));
    }

    const ContourOwners& owners_;
    SurfaceIncidence incidence_;
    std::vector<Chain> chains_;
};

// Membranes grown facet by facet from a chain, the cheapest first, until the rest of the rim lies on the
// surface.
class MembraneSearch {
  public:
    MembraneSearch(EditContext& edit, const Chain& chain, bool side)
        : edit_(edit), chain_(chain), side_(side), incidence_(edit) {}

    std::vector<Membrane> run() {
        waiting_.push({{}, chain_.vertices, 0, 0});
        return cheapest(most_membranes, [](const Membrane&) { return true; });
    }

    std::vector<Membrane> run_among(std::span<const std::uint32_t> vertices, const RimSides& sides_of_rim,
                                    const std::function<bool(const Membrane&)>& wanted) {
        among_ = vertices;
        rim_sides_ = &sides_of_rim;
        for (const std::uint32_t u : vertices) begin_at(u);
        return cheapest(most_across, wanted);
    }

  private:
    std::vector<Membrane> cheapest(std::size_t most, const std::function<bool(const Membrane&)>& wanted) {
        std::vector<Membrane> found;
        for (std::size_t n = 0; n < most_looked_at && !waiting_.empty() && found.size() < most; ++n) {
            Membrane membrane = waiting_.top();
            waiting_.pop();
            const std::size_t open = first_off_surface(membrane);
            if (open + 1 == membrane.path.size()) {
                if (wanted(membrane)) found.push_back(std::move(membrane));
                continue;
            }
            if (membrane.facets.size() == most_facets + chain_.vertices.size()) continue;
            const EdgeRing& edge = ring_of(membrane.path[open], membrane.path[open + 1]);
            if (!edge.closed) continue;
            for (const std::uint32_t w : edge.vertices) push(grown(membrane, open, w));
            // Elsewhere facets between two edges of the path alone: they may be all that the others wait for.
            for (std::size_t k = open + 1; k + 2 < membrane.path.size(); ++k) {
                if (is_facet(membrane.path[k], membrane.path[k + 1], membrane.path[k + 2]))
                    push(grown(membrane, k, membrane.path[k + 2]));
            }
        }
        return found;
    }

    void push(std::optional<Membrane> more) {
        if (!more || is_enclosed(*more) || !seen_.insert(more->facets).second) return;
        more->to_come = to_come(*more);
        waiting_.push(std::move(*more));
    }

    // Each facet on this side at an edge of the surface from the vertex on, alone.
    void begin_at(std::uint32_t u) {
        edit_.mesh.star(u, edit_.star);
        const std::vector<std::uint32_t> star = edit_.star;
        for (const std::uint32_t c : star) {
            if (incidence_.has(c, chain_.structure) != side_) continue;
            for (int i = 0; i < 4; ++i) {
                const std::uint32_t beyond = edit_.mesh.neighbor(c, i);
                if (edit_.mesh.cell(c)[i] == u || beyond == no_cell || beyond < c ||
                    incidence_.has(beyond, chain_.structure) != side_)
                    continue;
                const auto [v, w] = others_of_facet(edit_.mesh.cell(c), i, u);
                if (!is_among(v) || !is_among(w)) continue;
                std::array facet{u, v, w};
                std::sort(facet.begin(), facet.end());
                if (on_surface(u, v))
                    push(Membrane{{facet}, {u, w, v}, price(facet), 0});
                else if (on_surface(u, w))
                    push(Membrane{{facet}, {u, v, w}, price(facet), 0});
            }
        }
    }

    // Whether the part of the rim that lies on the surface already has no side left.
    bool is_enclosed(const Membrane& membrane) {
        if (!rim_sides_) return false;
        std::array<bool, 2> taken{};
        const std::vector<std::uint32_t>& path = membrane.path;
        bool on_before = true;  // the edge that joins its ends is
        for (std::size_t n = 0; n < path.size(); ++n) {
            const std::size_t next = (n + 1) % path.size();
            const bool on = next == 0 || on_surface(path[n], path[next]);
            if (on && on_before) {
                const auto [place, is_new] =
                    rim_sides_at_.try_emplace({path[n == 0 ? path.size() - 1 : n - 1], path[n], path[next]});
                const auto& [before, at, after] = place->first;
                if (is_new) place->second = (*rim_sides_)(before, at, after);
                for (std::size_t side = 0; side < 2; ++side) taken[side] = taken[side] || place->second[side];
            }
            on_before = on;
        }
        return taken[0] && taken[1];
    }

    bool is_among(std::uint32_t v) const {
        return among_.empty() || std::binary_search(among_.begin(), among_.end(), v);
    }

    // What is round an edge: asked for again and again, of few edges.
    struct EdgeRing {
        bool closed = false, on_surface = false;
        std::vector<std::uint32_t> vertices;
    };
    const EdgeRing& ring_of(std::uint32_t a, std::uint32_t b) {
        const auto [place, is_new] = rings_.try_emplace(std::minmax(a, b));
        EdgeRing& edge = place->second;
        if (is_new && incidence_.find_ring(a, b)) {
            edge = {true, incidence_.ring_is_mixed(chain_.structure), edit_.ring.ring};
        }
        return edge;
    }
    bool on_surface(std::uint32_t a, std::uint32_t b) { return ring_of(a, b).on_surface; }

    // The first edge of the path that is off the surface.
    std::size_t first_off_surface(const Membrane& membrane) {
        std::size_t n = 0;
        while (n + 1 < membrane.path.size() && on_surface(membrane.path[n], membrane.path[n + 1])) ++n;
        return n;
    }

    // By the facet at the path's edge n and a vertex; nothing where the membrane would meet itself, or touch
    // a surface within its rim.
    std::optional<Membrane> grown(const Membrane& membrane, std::size_t n, std::uint32_t w) {
        const std::uint32_t u = membrane.path[n], v = membrane.path[n + 1];
        std::array facet{u, v, w};
        std::sort(facet.begin(), facet.end());
        if (std::find(membrane.facets.begin(), membrane.facets.end(), facet) != membrane.facets.end())
            return std::nullopt;
        Membrane more = membrane;
        const auto at = more.path.begin() + static_cast<std::ptrdiff_t>(n);
        if (n > 0 && membrane.path[n - 1] == w) {
            if (!may_be_within(u)) return std::nullopt;
            more.path.erase(at);
        } else if (n + 2 < membrane.path.size() && membrane.path[n + 2] == w) {
            if (!may_be_within(v)) return std::nullopt;
            more.path.erase(at + 1);
        } else if (membrane.has(w) || chain_.has(w) || !is_among(w)) {
            return std::nullopt;
        } else {
            more.path.insert(at + 1, w);
        }
        more.facets.insert(std::upper_bound(more.facets.begin(), more.facets.end(), facet), facet);
        more.price += price(facet);
        return more;
    }

    bool is_facet(std::uint32_t u, std::uint32_t v, std::uint32_t w) {
        const EdgeRing& edge = ring_of(u, v);
        return std::find(edge.vertices.begin(), edge.vertices.end(), w) != edge.vertices.end();
    }

    bool may_be_within(std::uint32_t v) { return chain_.has(v) || !edit_.mesh.vertex_on_interface(v); }

    double price(const std::array<std::uint32_t, 3>& facet) {
        const auto [place, is_new] = prices_.try_emplace(facet);
        if (!is_new) return place->second;
        const Vec3 a = edit_.mesh.point(facet[0]), b = edit_.mesh.point(facet[1]),
                   c = edit_.mesh.point(facet[2]);
        const std::vector<std::uint32_t>& there = edit_.probe.members((1.0 / 3) * (a + b + c));
        const bool wrong = std::binary_search(there.begin(), there.end(), chain_.structure) == side_;
        return place->second = 0.5 * length(cross(b - a, c - a)) * (wrong ? wrong_side : 1);
    }

    double to_come(const Membrane& membrane) {
        double sum = 0;
        for (std::size_t n = 1; n < membrane.path.size(); ++n) {
            const std::uint32_t a = membrane.path[n - 1], b = membrane.path[n];
            if (!on_surface(a, b))
                sum += edge_price * squared_length(edit_.mesh.point(b) - edit_.mesh.point(a));
        }
        return sum;
    }

    EditContext& edit_;
    const Chain& chain_;
    bool side_;  // of the structure on which the chain lies
    SurfaceIncidence incidence_;
    std::span<const std::uint32_t> among_;  // if any: vertices, rising
    const RimSides* rim_sides_ = nullptr;
    std::map<std::array<std::uint32_t, 3>, std::array<bool, 2>> rim_sides_at_;
    std::set<std::vector<std::array<std::uint32_t, 3>>> seen_;
    std::priority_queue<Membrane, std::vector<Membrane>, Dearer> waiting_;
    std::map<std::pair<std::uint32_t, std::uint32_t>, EdgeRing> rings_;
    std::map<std::array<std::uint32_t, 3>, double> prices_;
};

}  // namespace

std::vector<Chain> find_chains(EditContext& edit, const ContourOwners& owners,
                               std::span<const std::array<std::uint32_t, 3>> subsegments) {
    return ChainSearch(edit, owners).run(subsegments);
}

std::vector<Membrane> find_membranes(EditContext& edit, const Chain& chain, bool side) {
    return MembraneSearch(edit, chain, side).run();
}

std::vector<Membrane> find_membranes_across(EditContext& edit, std::uint32_t structure, bool side,
                                            std::span<const std::uint32_t> vertices,
                                            const RimSides& rim_sides,
                                            const std::function<bool(const Membrane&)>& wanted) {
    const Chain none{{}, structure};
    return MembraneSearch(edit, none, side).run_among(vertices, rim_sides, wanted);
}

}  // namespace anatomesh
