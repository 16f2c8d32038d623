#include "anatomesh/improve/smooth/ratio_slopes.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numeric>

#include "anatomesh/base/parallel.h"
#include "anatomesh/geom/vec.h"
#include "anatomesh/mesh/model/prefetch.h"

namespace anatomesh {

namespace {

// The cells are summed in so many pieces, each on its own, so that sums are the same at any number of
// threads. [pieces; > 0; B]
constexpr std::size_t pieces = 2;
// It stands for no region so far. [region; 2^16 - 1; D]
constexpr Region unmet = 0xFFFF;

struct Gathered {                               // of a vertex
    std::array<float, 3> gradient{}, normal{};  // of the sum; of the interface
    float sum = 0, edges = 0;                   // of the cells inside: ratios, edges
    std::uint32_t cells = 0;                    // inside
    Region region = unmet;                      // of the first cell met
    std::uint8_t several = 0;                   // regions
};

void add(std::array<float, 3>& sum, Vec3 v) {
    sum[0] += static_cast<float>(v.x);
    sum[1] += static_cast<float>(v.y);
    sum[2] += static_cast<float>(v.z);
}

// Shapes of a cell inside. Gives its ratio.
double add_cell(const TetMesh& mesh, std::size_t c, std::vector<Gathered>& at) {
    const Cell& cell = mesh.cells[c];
    const Vec3 origin = mesh.points[cell[0]];
    const std::array<Vec3, 4> p{Vec3{}, mesh.points[cell[1]] - origin, mesh.points[cell[2]] - origin,
                                mesh.points[cell[3]] - origin};
    const Vec3 n1 = cross(p[2], p[3]), n2 = cross(p[3], p[1]), n3 = cross(p[1], p[2]);
    const double volume6 = dot(n3, p[3]), inverse = 1 / volume6;
    const Vec3 center =
        (0.5 * inverse) * (squared_length(p[3]) * n3 + squared_length(p[2]) * n2 + squared_length(p[1]) * n1);
    const double b1 = dot(center, n1) * inverse, b2 = dot(center, n2) * inverse,
                 b3 = dot(center, n3) * inverse;
    const std::array<double, 4> barycentric{1 - b1 - b2 - b3, b1, b2, b3};
    std::size_t from = 0, to = 1;  // of the shortest edge
    double shortest = INFINITY, squares = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t k = i + 1; k < 4; ++k) {
            const double squared = squared_length(p[k] - p[i]);
            squares += squared;
            if (squared < shortest) shortest = squared, from = i, to = k;
        }
    }
    const double squared_radius = squared_length(center), ratio = std::sqrt(squared_radius / shortest);
    const double growing = ratio / squared_radius, shrinking = ratio / shortest;
    const Vec3 along = shrinking * (p[to] - p[from]);
    const auto edge = static_cast<float>(std::sqrt(squares / 6));
    for (std::size_t i = 0; i < 4; ++i) {
        Vec3 slope = (growing * barycentric[i]) * (p[i] - center);
        if (i == from) slope = slope + along;
        if (i == to) slope = slope - along;
        Gathered& vertex = at[cell[i]];
        add(vertex.gradient, slope);
        vertex.sum += static_cast<float>(ratio);
        vertex.edges += edge;
        ++vertex.cells;
    }
    return ratio;
}

// The interface's facets of a cell, each seen from one of its sides.
void add_facets(const TetMesh& mesh, std::span<const std::uint32_t> neighbors, std::size_t c,
                std::vector<Gathered>& at) {
    const Cell& cell = mesh.cells[c];
    for (std::size_t i = 0; i < 4; ++i) {
        const std::uint32_t across = neighbors[4 * c + i];
        if (across == no_cell || mesh.regions[across] >= mesh.regions[c]) continue;
        const std::uint32_t u = cell[facet_vertices[i][0]], v = cell[facet_vertices[i][1]],
                            w = cell[facet_vertices[i][2]];
        const Vec3 normal = cross(mesh.points[v] - mesh.points[u], mesh.points[w] - mesh.points[u]);
        for (const std::uint32_t n : {u, v, w}) add(at[n].normal, normal);
    }
}

void join(Gathered& one, const Gathered& other) {
    for (std::size_t k = 0; k < 3; ++k) {
        one.gradient[k] += other.gradient[k];
        one.normal[k] += other.normal[k];
    }
    one.sum += other.sum;
    one.edges += other.edges;
    one.cells += other.cells;
    one.several |=
        other.several | (one.region != unmet && other.region != unmet && one.region != other.region);
    if (one.region == unmet) one.region = other.region;
}

float steepness_of(const Gathered& vertex) {
    if (vertex.cells == 0) return 0;
    const auto vector = [](const std::array<float, 3>& v) { return Vec3{v[0], v[1], v[2]}; };
    Vec3 slope = vector(vertex.gradient);
    const Vec3 normal = vector(vertex.normal);
    const double squared = squared_length(normal);
    if (squared > 0) slope = slope - (dot(slope, normal) / squared) * normal;
    return static_cast<float>(length(slope) * vertex.edges / (vertex.sum * vertex.cells));
}

}  // namespace

RatioSlopes ratio_slopes(const TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                         std::span<const std::uint8_t> fixed, int threads) {
    assert(neighbors.size() == 4 * mesh.cells.size() && fixed.size() == mesh.points.size());
    std::array<std::vector<Gathered>, pieces> gathered;
    std::array<double, pieces> ratios{};
    std::array<std::uint64_t, pieces> counts{};
    const std::size_t grain = std::max<std::size_t>(1, (mesh.cells.size() + pieces - 1) / pieces);
    for (auto& piece : gathered) piece.resize(mesh.points.size());
    parallel_for(mesh.cells.size(), grain, threads, [&](std::size_t first, std::size_t last) {
        std::vector<Gathered>& at = gathered[first / grain];
        double ratio = 0;
        std::uint64_t count = 0;
        for (std::size_t c = first; c < last; ++c) {
            if (c + cells_ahead < last) {
                const Cell& soon = mesh.cells[c + cells_ahead];
                prefetch_points(mesh.points, soon);
                for (const std::uint32_t v : soon) __builtin_prefetch(&at[v], 1);
            }
            const Region region = mesh.regions[c];
            for (const std::uint32_t v : mesh.cells[c]) {
                if (at[v].region == unmet) at[v].region = region;
                at[v].several |= at[v].region != region;
            }
            if (region == 0) continue;
            ratio += add_cell(mesh, c, at);
            ++count;
            add_facets(mesh, neighbors, c, at);
        }
        ratios[first / grain] = ratio;
        counts[first / grain] = count;
    });
    RatioSlopes slopes{std::vector<float>(mesh.points.size(), 0),
                       std::vector<std::uint8_t>(mesh.points.size(), 0)};
    slopes.cells = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
    slopes.mean = std::accumulate(ratios.begin(), ratios.end(), 0.0) /
                  static_cast<double>(std::max<std::uint64_t>(1, slopes.cells));
    parallel_for(mesh.points.size(), 16384, threads, [&](std::size_t first, std::size_t last) {
        for (std::size_t v = first; v < last; ++v) {
            for (std::size_t k = 1; k < pieces; ++k) join(gathered[0][v], gathered[k][v]);
            slopes.on_interface[v] = gathered[0][v].several;
            if (!fixed[v]) slopes.steepness[v] = steepness_of(gathered[0][v]);
        }
    });
    return slopes;
}

}  // namespace anatomesh
