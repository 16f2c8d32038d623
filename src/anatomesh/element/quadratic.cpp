#include "anatomesh/element/quadratic.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>
#include <vector>

#include "anatomesh/base/parallel.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/model/buckets.h"

namespace anatomesh {

namespace {

// A shorter mean of the unit normals on both sides is a crease, of 74 degrees. [1; 0 to 1; M 2026-11, set not recorded]
constexpr double flattest_crease = 0.8;
constexpr int halvings =
    4;  // A node pulled back more often than this goes to the middle. [halvings; >= 0; B]
// A thread takes so many cells at a time. [cells; >= 1; B]
constexpr std::size_t grain = 1024;

using Edge = std::array<std::uint32_t, 2>;

Edge edge_of(const Cell& cell, std::size_t e) {
    const std::uint32_t a = cell[static_cast<std::size_t>(cell_edges[e][0])];
    const std::uint32_t b = cell[static_cast<std::size_t>(cell_edges[e][1])];
    return {std::min(a, b), std::max(a, b)};
}

// Every edge once, sorted, and the six of every cell as indices into them.
struct Edges {
    std::vector<Edge> all;
    std::vector<std::array<std::uint32_t, 6>> of_cell;

    explicit Edges(const TetMesh& mesh) : of_cell(mesh.cells.size()) {
        // The id of a place, 6 c + e, may need more than 32 bits: cells are filed in place of them.
        const Buckets buckets = fill_buckets(mesh.points.size(), [&](const auto& emit) {
            for (std::uint32_t c = 0; c < mesh.cells.size(); ++c) {
                for (std::size_t e = 0; e < 6; ++e) {
                    const Edge edge = edge_of(mesh.cells[c], e);
                    emit(edge[0], (std::uint64_t{edge[1]} << 3) | e, c);
                }
            }
        });
        for (std::uint32_t v = 0; v + 1 < buckets.start.size(); ++v) {
            for (std::size_t n = buckets.start[v]; n < buckets.start[v + 1]; ++n) {
                const auto other = static_cast<std::uint32_t>(buckets.entries[n].key >> 3);
                if (all.empty() || all.back() != Edge{v, other}) all.push_back({v, other});
                of_cell[buckets.entries[n].id][buckets.entries[n].key & 7] =
                    static_cast<std::uint32_t>(all.size() - 1);
            }
        }
    }
    // Requires: it is there.
    std::size_t find(Edge edge) const {
        if (edge[0] > edge[1]) std::swap(edge[0], edge[1]);
        return static_cast<std::size_t>(std::lower_bound(all.begin(), all.end(), edge) - all.begin());
    }
};

// What the interface is at an edge.
struct EdgeInterface {
    enum class Kind : std::uint8_t { none, smooth, segment, junction };
    Kind kind = Kind::none;
    Region inner = 0, outer = 0;  // inner > outer
    Vec3 normal;                  // sum of the unit normals of its facets, from inner to outer
    int facets = 0;
};

std::vector<EdgeInterface> interfaces_at(const TetMesh& mesh, const Edges& edges,
                                         std::span<const std::array<std::uint32_t, 2>> segment_edges) {
    using Kind = EdgeInterface::Kind;
    std::vector<EdgeInterface> at(edges.all.size());
    const std::vector<std::uint32_t> neighbors = cell_neighbors(mesh.cells, mesh.points.size());
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        for (std::size_t i = 0; i < 4; ++i) {
            const std::uint32_t n = neighbors[4 * c + i];
            const Region inner = mesh.regions[c], outer = n == no_cell ? Region{0} : mesh.regions[n];
            if (inner <= outer) continue;
            std::array<Vec3, 3> p;
            for (std::size_t k = 0; k < 3; ++k) {
                p[k] = mesh.points[mesh.cells[c][static_cast<std::size_t>(facet_vertices[i][k])]];
            }
            const Vec3 normal = cross(p[1] - p[0], p[2] - p[0]);
            const double size = length(normal);
            for (std::size_t e = 0; e < 6; ++e) {
                const auto [a, b] = cell_edges[e];
                if (static_cast<std::size_t>(a) == i || static_cast<std::size_t>(b) == i) continue;
                EdgeInterface& edge = at[edges.of_cell[c][e]];
                if (edge.kind == Kind::none) {
                    edge.kind = Kind::smooth;
                    edge.inner = inner;
                    edge.outer = outer;
                } else if (edge.inner != inner || edge.outer != outer) {
                    edge.kind = Kind::junction;
                }
                if (size > 0) edge.normal += (1 / size) * normal;
                ++edge.facets;
            }
        }
    }
    for (EdgeInterface& edge : at) {
        if (edge.kind != Kind::smooth) continue;
        const double flatness = length(edge.normal) / edge.facets;
        if (edge.facets > 2 || !(flatness > flattest_crease)) edge.kind = Kind::junction;
    }
    for (const Edge edge : segment_edges) {
        const std::size_t found = edges.find(edge);
        if (found < at.size() && at[found].kind != Kind::none) at[found].kind = Kind::segment;
    }
    return at;
}

// The first structure that lies on one side of the interface only, and whether that is the inner side.
struct Side {
    std::uint32_t structure = 0;
    bool inner = true;
};
std::optional<Side> side_of(const RegionTable& regions, Region inner, Region outer) {
    const auto &in = regions.members[inner], &out = regions.members[outer];
    std::vector<std::uint32_t> differ;
    std::set_symmetric_difference(in.begin(), in.end(), out.begin(), out.end(), std::back_inserter(differ));
    if (differ.empty()) return std::nullopt;
    return Side{differ.front(), std::binary_search(in.begin(), in.end(), differ.front())};
}

// Where the structure's value changes its sign on the way from p along `direction`, at most `reach` from p;
// the distance from p. Bracketed with steps that follow the value, which is about a distance, then halved or
// better (Illinois method: Dowell and Jarratt, BIT 11, 1971).
class Crossing {
  public:
    Crossing(const ModelField& field, std::uint32_t structure, Vec3 p, Vec3 direction, double tolerance)
        : field_(field), structure_(structure), p_(p), direction_(direction), tolerance_(tolerance) {}

    // Requires: `at_p` is the value at p, and the value falls in magnitude along the direction.
    std::optional<double> within(double reach, double at_p) const {
        double near = 0, at_near = at_p;
        for (double step = std::max(1.1 * std::abs(at_p), 4 * tolerance_); near < reach; step *= 1.6) {
            const double far = std::min(near + step, reach);
            const double at_far = value(far);
            if ((at_far < 0) != (at_p < 0)) return between(near, far, at_near, at_far);
            near = far;
            at_near = at_far;
        }
        return std::nullopt;
    }
    double value(double t) const {
        return field_.field.value(structure_, p_ + t * direction_ - field_.origin);
    }

  private:
    double between(double low, double high, double at_low, double at_high) const {
        for (int step = 0; step < 60 && high - low > tolerance_; ++step) {
            double t = low + (high - low) * at_low / (at_low - at_high);
            if (!(t > low && t < high) || step % 4 == 3) t = 0.5 * (low + high);
            const double here = value(t);
            if (std::abs(here) < 0.1 * tolerance_) return t;
            if ((here < 0) == (at_low < 0)) {
                low = t;
                at_low = here;
                at_high *= 0.5;
            } else {
                high = t;
                at_high = here;
                at_low *= 0.5;
            }
        }
        return 0.5 * (low + high);
    }

    const ModelField& field_;
    std::uint32_t structure_;
    Vec3 p_, direction_;
    double tolerance_;
};

// From the middle of an edge to the interface, straight above it; nothing where there is none within reach.
std::optional<Vec3> offset_to_interface(const RegionTable& regions, const EdgeInterface& at, Vec3 a, Vec3 b,
                                        const ModelField& field, const QuadraticOptions& options) {
    const auto side = side_of(regions, at.inner, at.outer);
    if (!side) return std::nullopt;
    const Vec3 middle = 0.5 * (a + b);
    const Vec3 outwards = (side->inner ? 1.0 : -1.0) * normalized(at.normal);
    const double value = field.field.value(side->structure, middle - field.origin);
    if (std::abs(value) <= options.tolerance_mm) return Vec3{};
    const Vec3 direction = value < 0 ? outwards : -outwards;
    const Crossing crossing(field, side->structure, middle, direction, options.tolerance_mm);
    const auto t = crossing.within(options.max_offset * length(b - a), value);
    if (!t) return std::nullopt;
    return *t * direction;
}

// Nodes on their way from the middles to the interface, and how far each was pulled back.
class Bending {
  public:
    Bending(const TetMesh& mesh, const RegionTable& regions, const ModelField& field,
            std::span<const std::array<std::uint32_t, 2>> segment_edges, const QuadraticOptions& options,
            RunContext& context)
        : mesh_(mesh),
          edges_(mesh),
          options_(options),
          context_(context),
          offsets_(edges_.all.size()),
          halved_(edges_.all.size(), 0) {
        find_offsets(regions, field, interfaces_at(mesh, edges_, segment_edges));
    }

    // Halves the offsets of the nodes of elements too near to folding until there are none. Every round
    // halves one offset at least, and straight elements never are.
    Status pull_back() {
        std::vector<double> least(mesh_.cells.size(), 1);
        for (;;) {
            if (context_.cancelled()) return cancelled_error();
            parallel_for(mesh_.cells.size(), grain, context_.threads,
                         [&](std::size_t begin, std::size_t end) {
                             for (std::size_t c = begin; c < end; ++c)
                                 least[c] = is_straight(c) ? 1 : least_jacobian(element(c));
                         });
            std::vector<std::uint32_t> nodes;
            for (std::size_t c = 0; c < least.size(); ++c) {
                if (least[c] >= options_.min_jacobian) continue;
                for (const std::uint32_t n : edges_.of_cell[c]) {
                    if (offset(n) != Vec3{}) nodes.push_back(n);
                }
            }
            if (nodes.empty()) break;
            std::sort(nodes.begin(), nodes.end());
            nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
            for (const std::uint32_t n : nodes) ++halved_[n];
        }
        for (const double each : least) stats_.least_jacobian = std::min(stats_.least_jacobian, each);
        return Nothing{};
    }

    QuadraticResult result() {
        QuadraticResult result;
        result.mid_nodes.cells = edges_.of_cell;
        result.mid_nodes.points.reserve(edges_.all.size());
        for (std::uint32_t n = 0; n < edges_.all.size(); ++n) {
            result.mid_nodes.points.push_back(node(n));
            stats_.largest_offset_mm = std::max(stats_.largest_offset_mm, length(offset(n)));
            if (halved_[n] > halvings)
                ++stats_.straightened;
            else if (halved_[n] > 0)
                ++stats_.pulled_back;
        }
        stats_.nodes = edges_.all.size();
        stats_.on_interface = stats_.interface_nodes - stats_.segment_nodes - stats_.junction_nodes -
                              stats_.out_of_reach - stats_.pulled_back - stats_.straightened;
        for (std::size_t c = 0; c < mesh_.cells.size(); ++c)
            stats_.volume_mm3 += quadratic_volume(element(c));
        result.stats = stats_;
        return result;
    }

  private:
    void find_offsets(const RegionTable& regions, const ModelField& field,
                      const std::vector<EdgeInterface>& at) {
        using Kind = EdgeInterface::Kind;
        std::vector<std::uint8_t> missed(at.size(), 0);
        parallel_for(at.size(), grain, context_.threads, [&](std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) {
                if (at[n].kind != Kind::smooth) continue;
                const auto& [a, b] = edges_.all[n];
                const auto offset =
                    offset_to_interface(regions, at[n], mesh_.points[a], mesh_.points[b], field, options_);
                missed[n] = !offset;
                offsets_[n] = offset.value_or(Vec3{});
            }
        });
        for (std::size_t n = 0; n < at.size(); ++n) {
            stats_.interface_nodes += at[n].kind != Kind::none;
            stats_.segment_nodes += at[n].kind == Kind::segment;
            stats_.junction_nodes += at[n].kind == Kind::junction;
            stats_.out_of_reach += missed[n];
        }
    }

    Vec3 offset(std::uint32_t n) const {
        return halved_[n] > halvings ? Vec3{} : std::ldexp(1.0, -halved_[n]) * offsets_[n];
    }
    Vec3 node(std::uint32_t n) const {
        const auto& [a, b] = edges_.all[n];
        return 0.5 * (mesh_.points[a] + mesh_.points[b]) + offset(n);
    }
    bool is_straight(std::size_t c) const {
        return std::all_of(edges_.of_cell[c].begin(), edges_.of_cell[c].end(),
                           [&](std::uint32_t n) { return offset(n) == Vec3{}; });
    }
    QuadraticElement element(std::size_t c) const {
        QuadraticElement element;
        for (std::size_t i = 0; i < 4; ++i) element.corners[i] = mesh_.points[mesh_.cells[c][i]];
        for (std::size_t e = 0; e < 6; ++e) element.mid_nodes[e] = node(edges_.of_cell[c][e]);
        return element;
    }

    const TetMesh& mesh_;
    const Edges edges_;
    const QuadraticOptions& options_;
    RunContext& context_;
    std::vector<Vec3> offsets_;
    std::vector<std::int8_t> halved_;
    QuadraticStats stats_;
};

}  // namespace

MidNodes straight_mid_nodes(const TetMesh& mesh) {
    Edges edges(mesh);
    MidNodes mid_nodes;
    mid_nodes.points.reserve(edges.all.size());
    for (const auto& [a, b] : edges.all) mid_nodes.points.push_back(0.5 * (mesh.points[a] + mesh.points[b]));
    mid_nodes.cells = std::move(edges.of_cell);
    return mid_nodes;
}

Result<QuadraticResult> quadratic_elements(const TetMesh& mesh, const RegionTable& regions,
                                           const ModelField& field,
                                           std::span<const std::array<std::uint32_t, 2>> segment_edges,
                                           const QuadraticOptions& options, RunContext& context) {
    assert(options.max_offset >= 0 && options.min_jacobian > 0 && options.min_jacobian <= 0.9);
    Bending bending(mesh, regions, field, segment_edges, options, context);
    ANATOMESH_CHECK_STATUS(bending.pull_back());
    return bending.result();
}

}  // namespace anatomesh
