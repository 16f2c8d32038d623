#include "anatomesh/element/jacobian.h"

#include <algorithm>
#include <numeric>

#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

namespace {

// differences[i][k]: half the derivative towards corner k + 1 (away from corner 0), as it stands at corner i;
// the derivative is linear, so these four values are the whole of it.
using Differences = std::array<std::array<Vec3, 3>, 4>;

Differences differences_of(const QuadraticElement& element) {
    // Control points of the element as a quadratic Bezier tetrahedron.
    std::array<std::array<Vec3, 4>, 4> control;
    for (std::size_t i = 0; i < 4; ++i) control[i][i] = element.corners[i];
    for (std::size_t e = 0; e < 6; ++e) {
        const auto a = static_cast<std::size_t>(cell_edges[e][0]),
                   b = static_cast<std::size_t>(cell_edges[e][1]);
        control[a][b] = control[b][a] =
            2.0 * element.mid_nodes[e] - 0.5 * (element.corners[a] + element.corners[b]);
    }
    Differences differences;
    for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t k = 0; k < 3; ++k) differences[i][k] = control[i][k + 1] - control[i][0];
    }
    return differences;
}

// Place of the coefficient of corners i, j, k (in any order) among the twenty.
struct Places {
    std::array<std::array<std::array<std::uint8_t, 4>, 4>, 4> of{};
    std::array<std::uint8_t, 20> orders{};  // in how many orders its corners come

    constexpr Places() {
        std::uint8_t next = 0;
        for (std::size_t i = 0; i < 4; ++i) {
            for (std::size_t j = i; j < 4; ++j) {
                for (std::size_t k = j; k < 4; ++k) {
                    of[i][j][k] = of[i][k][j] = of[j][i][k] = of[j][k][i] = of[k][i][j] = of[k][j][i] =
                        next++;
                }
            }
        }
        for (const auto& plane : of) {
            for (const auto& row : plane) {
                for (const std::uint8_t place : row) ++orders[place];
            }
        }
    }
};
constexpr Places places;

double straight_jacobian(const QuadraticElement& element) {
    const auto& c = element.corners;
    return dot(cross(c[1] - c[0], c[2] - c[0]), c[3] - c[0]);
}

}  // namespace

std::array<double, 20> jacobian_coefficients(const QuadraticElement& element) {
    const Differences d = differences_of(element);
    std::array<double, 20> coefficients{};
    for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t j = 0; j < 4; ++j) {
            const Vec3 normal = cross(d[i][0], d[j][1]);
            for (std::size_t k = 0; k < 4; ++k) coefficients[places.of[i][j][k]] += 8 * dot(normal, d[k][2]);
        }
    }
    for (std::size_t n = 0; n < coefficients.size(); ++n) coefficients[n] /= places.orders[n];
    return coefficients;
}

double least_jacobian(const QuadraticElement& element) {
    const std::array<double, 20> coefficients = jacobian_coefficients(element);
    return *std::min_element(coefficients.begin(), coefficients.end()) / straight_jacobian(element);
}

double quadratic_volume(const QuadraticElement& element) {
    const std::array<double, 20> coefficients = jacobian_coefficients(element);
    return std::accumulate(coefficients.begin(), coefficients.end(), 0.0) / 120;
}

double jacobian_at(const QuadraticElement& element, const std::array<double, 4>& barycentric) {
    const Differences d = differences_of(element);
    std::array<Vec3, 3> derivative{};
    for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t k = 0; k < 3; ++k) derivative[k] += 2 * barycentric[i] * d[i][k];
    }
    return dot(cross(derivative[0], derivative[1]), derivative[2]);
}

}  // namespace anatomesh
