#include "anatomesh/improve/smooth/star_ratios.h"

#include <algorithm>
#include <cmath>

#include "anatomesh/improve/labelled_meshes_for_test.h"
#include "anatomesh/improve/smooth/vertex_mover.h"
#include "anatomesh/mesh/stars/star.h"

namespace anatomesh::star_ratios_test {
namespace {

using namespace fixtures;

constexpr double least_sine_wanted = 0.2756;

// Of the cells inside, by the measures of the mesh room.
double sum_of_ratios(const TetMesh& mesh, std::span<const std::uint32_t> star) {
    double sum = 0;
    for (const std::uint32_t n : star) {
        const Cell& c = mesh.cells[n];
        if (mesh.regions[n] == 0) continue;
        if (orient3d(mesh.points[c[0]], mesh.points[c[1]], mesh.points[c[2]], mesh.points[c[3]]) <= 0)
            return INFINITY;
        sum += radius_edge_ratio(mesh.points[c[0]], mesh.points[c[1]], mesh.points[c[2]], mesh.points[c[3]]);
    }
    return sum;
}

// Calls body(mesh, mover, star, vertex, move in mean edges, ratios) for vertices that may move.
template <class Body>
void each_move(const Body& body) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> any(-1, 1);
    for (LabelledCase& made : labelled_cases()) {
        SCOPED_TRACE(made.name);
        const VertexStars stars(made.mesh.cells, made.mesh.points.size());
        VertexMover mover(made.mesh, stars, 2, least_sine_wanted);
        for (std::uint32_t v = 0; v < made.mesh.points.size(); v += 7) {
            const auto star = mover.star(v);
            if (made.fixed[v] || star.size() > StarRatios::most_cells) continue;
            const StarRatios ratios(made.mesh, star, v);
            if (ratios.mean_edge() == 0) continue;
            const double size = 0.02 * std::pow(2.0, v % 5);
            body(made.mesh, mover, star, v, size * Vec3{any(random), any(random), any(random)}, ratios);
        }
    }
}

TEST(StarRatios, sums_the_ratios_of_the_cells_inside_wherever_the_vertex_goes) {
    std::size_t inverted = 0, count = 0;
    each_move(
        [&](TetMesh& mesh, VertexMover&, auto star, std::uint32_t v, Vec3 move, const StarRatios& ratios) {
            const Vec3 from = mesh.points[v];
            mesh.points[v] = from + ratios.mean_edge() * move;
            const double expected = sum_of_ratios(mesh, star);
            mesh.points[v] = from;
            const double sum = ratios.sum(move);
            Vec3 gradient;
            ++count;
            if (std::isinf(expected) || std::isinf(sum) || expected > 1e3) {
                inverted += std::isinf(expected);
                // A nearly flat cell may count as either.
                ASSERT_TRUE(sum > 900 || expected > 900);
                return;
            }
            ASSERT_NEAR(sum, expected, 2e-3 * expected);
            ASSERT_NEAR(ratios.sum(move, gradient), sum, 1e-5 * sum);
        });
    EXPECT_GT(count, 1000u);
    EXPECT_GT(inverted, 10u);
}

TEST(StarRatios, the_gradient_is_that_of_the_sum) {
    std::size_t count = 0;
    each_move([&](TetMesh&, VertexMover&, auto, std::uint32_t, Vec3 move, const StarRatios& ratios) {
        if (!(length(move) < 0.2)) return;
        Vec3 gradient;
        const double here = ratios.sum(move, gradient);
        if (!(here < 40)) return;
        // Where the shortest edges change the sum has a kink: differences to both sides must agree.
        constexpr double step = 0.004;
        const Vec3 along = normalized(gradient);
        const double up = ratios.sum(move + step * along) - here,
                     down = here - ratios.sum(move - step * along);
        if (!(std::abs(up - down) < 0.03 * std::abs(up))) return;
        ++count;
        ASSERT_NEAR(0.5 * (up + down) / step, length(gradient), 0.06 * length(gradient) + 0.02);
    });
    EXPECT_GT(count, 200u);
}

TEST(StarRatios, judges_as_the_mover_does) {
    std::size_t good = 0, bad = 0, unsure = 0;
    each_move(
        [&](TetMesh& mesh, VertexMover& mover, auto, std::uint32_t v, Vec3 move, const StarRatios& ratios) {
            const Vec3 from = mesh.points[v];
            const bool moved = mover.try_move(v, from + ratios.mean_edge() * move);
            mesh.points[v] = from;
            switch (ratios.judge(move, 2, least_sine_wanted)) {
                case StarRatios::Verdict::good:
                    ++good;
                    ASSERT_TRUE(moved);
                    break;
                case StarRatios::Verdict::bad:
                    ++bad;
                    ASSERT_FALSE(moved);
                    break;
                default:
                    ++unsure;
            }
        });
    EXPECT_GT(good, 200u);
    EXPECT_GT(bad, 200u);
    EXPECT_GT(unsure, 0u);
}

}  // namespace
}  // namespace anatomesh::star_ratios_test
