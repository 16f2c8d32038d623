#include "anatomesh/improve/smooth/star_ratios.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "anatomesh/base/instruction_sets.h"

namespace anatomesh {

namespace {

// Facets that fill up the lanes lie so far away that their ratios do not count. [mm; > 0; D]
constexpr float far_away = 1e12f;
// What is better than needed by this factor in single precision is better. [1; > 1; D]
constexpr float surely = 1.01f;
// Six volumes of a cell next to flat, which single precision cannot judge. [cubes of the longest edge; > 0;
// D]
constexpr float nearly_flat_shape = 1e-3f;

}  // namespace

StarRatios::StarRatios(const TetMesh& mesh, std::span<const std::uint32_t> star, std::uint32_t v) {
    assert(star.size() <= most_cells);
    for (const std::uint32_t c : star) {
        if (mesh.regions[c] != 0) add(count_.inside++, mesh, c, v);
    }
    double length_sum = 0;
    for (std::size_t n = 0; n < count_.inside; ++n)
        length_sum += std::sqrt(p_.x[n] * p_.x[n] + p_.y[n] * p_.y[n] + p_.z[n] * p_.z[n]);
    mean_edge_ = count_.inside == 0 ? 0 : length_sum / static_cast<double>(count_.inside);
    count_.outside = count_.end = (count_.inside + lanes - 1) / lanes * lanes;
    if (count_.inside < star.size()) {
        for (const std::uint32_t c : star) {
            if (mesh.regions[c] == 0) add(count_.end++, mesh, c, v);
        }
    }
    prepare();
    fill_up(count_.inside, count_.outside);
}

// (v, p, q, r) is positive when p, q, r run counter-clockwise seen from v.
void StarRatios::add(std::size_t n, const TetMesh& mesh, std::uint32_t cell, std::uint32_t v) {
    static constexpr std::uint8_t others[4][3] = {{1, 2, 3}, {0, 3, 2}, {3, 0, 1}, {2, 1, 0}};
    const Cell& c = mesh.cells[cell];
    const std::size_t k = c[0] == v ? 0 : c[1] == v ? 1 : c[2] == v ? 2 : 3;
    const Vec3 at = mesh.points[v];
    const auto put = [&](Rows& rows, std::uint32_t u) {
        const Vec3 d = mesh.points[u] - at;
        rows.x[n] = static_cast<float>(d.x);
        rows.y[n] = static_cast<float>(d.y);
        rows.z[n] = static_cast<float>(d.z);
    };
    put(p_, c[others[k][0]]);
    put(q_, c[others[k][1]]);
    put(r_, c[others[k][2]]);
}

// Facets whose ratios are next to nothing wherever the vertex is.
void StarRatios::fill_up(std::size_t first, std::size_t last) {
    for (std::size_t n = first; n < last; ++n) {
        for (Rows* rows : {&p_, &q_, &r_}) rows->x[n] = rows->y[n] = rows->z[n] = 2 * far_away;
        for (Rows* rows : {&center_, &normal_}) rows->x[n] = rows->y[n] = rows->z[n] = 0;
        height_[n] = squared_radius_[n] = twice_area_[n] = 1;
        squared_shortest_[n] = squared_longest_[n] = far_away * far_away;
    }
}

ANATOMESH_CLONES void StarRatios::prepare() {
    const float scale = mean_edge_ > 0 ? static_cast<float>(1 / mean_edge_) : 1.0f;
    for (std::size_t n = 0; n < count_.end; ++n) {
        const float px = p_.x[n] * scale, py = p_.y[n] * scale, pz = p_.z[n] * scale;
        const float qx = q_.x[n] * scale, qy = q_.y[n] * scale, qz = q_.z[n] * scale;
        const float rx = r_.x[n] * scale, ry = r_.y[n] * scale, rz = r_.z[n] * scale;
        p_.x[n] = px, p_.y[n] = py, p_.z[n] = pz;
        q_.x[n] = qx, q_.y[n] = qy, q_.z[n] = qz;
        r_.x[n] = rx, r_.y[n] = ry, r_.z[n] = rz;
    }
    for (std::size_t n = 0; n < count_.end; ++n) {
        const float ax = q_.x[n] - p_.x[n], ay = q_.y[n] - p_.y[n], az = q_.z[n] - p_.z[n];
        const float bx = r_.x[n] - p_.x[n], by = r_.y[n] - p_.y[n], bz = r_.z[n] - p_.z[n];
        const float cx = r_.x[n] - q_.x[n], cy = r_.y[n] - q_.y[n], cz = r_.z[n] - q_.z[n];
        const float nx = ay * bz - az * by, ny = az * bx - ax * bz, nz = ax * by - ay * bx;
        const float a2 = ax * ax + ay * ay + az * az, b2 = bx * bx + by * by + bz * bz,
                    c2 = cx * cx + cy * cy + cz * cz, n2 = nx * nx + ny * ny + nz * nz;
        const float half = 0.5f / n2;
        const float ux = half * (a2 * (by * nz - bz * ny) + b2 * (ny * az - nz * ay));
        const float uy = half * (a2 * (bz * nx - bx * nz) + b2 * (nz * ax - nx * az));
        const float uz = half * (a2 * (bx * ny - by * nx) + b2 * (nx * ay - ny * ax));
        const float area = std::sqrt(n2), inverse = -1 / area;
        const float nearer = b2 < a2 ? b2 : a2, farther = b2 < a2 ? a2 : b2;
        squared_radius_[n] = ux * ux + uy * uy + uz * uz;
        squared_shortest_[n] = c2 < nearer ? c2 : nearer;
        squared_longest_[n] = c2 < farther ? farther : c2;
        twice_area_[n] = area;
        center_.x[n] = p_.x[n] + ux, center_.y[n] = p_.y[n] + uy, center_.z[n] = p_.z[n] + uz;
        normal_.x[n] = nx * inverse, normal_.y[n] = ny * inverse, normal_.z[n] = nz * inverse;
        height_[n] = -(normal_.x[n] * p_.x[n] + normal_.y[n] * p_.y[n] + normal_.z[n] * p_.z[n]);
    }
}

ANATOMESH_CLONES double StarRatios::sum(Vec3 move) const {
    const auto x = static_cast<float>(move.x), y = static_cast<float>(move.y), z = static_cast<float>(move.z);
    constexpr float infinity = std::numeric_limits<float>::infinity();
    Row ratio;
    for (std::size_t n = 0; n < count_.outside; ++n) {
        const float dx = x - center_.x[n], dy = y - center_.y[n], dz = z - center_.z[n];
        const float height = normal_.x[n] * x + normal_.y[n] * y + normal_.z[n] * z + height_[n];
        const float t = (dx * dx + dy * dy + dz * dz - squared_radius_[n]) / (2 * height);
        const float ax = x - p_.x[n], ay = y - p_.y[n], az = z - p_.z[n];
        const float bx = x - q_.x[n], by = y - q_.y[n], bz = z - q_.z[n];
        const float cx = x - r_.x[n], cy = y - r_.y[n], cz = z - r_.z[n];
        const float a2 = ax * ax + ay * ay + az * az, b2 = bx * bx + by * by + bz * bz,
                    c2 = cx * cx + cy * cy + cz * cz;
        const float ab = a2 < b2 ? a2 : b2, cf = c2 < squared_shortest_[n] ? c2 : squared_shortest_[n];
        const float shortest = ab < cf ? ab : cf;
        const float value = std::sqrt((squared_radius_[n] + t * t) / shortest);
        ratio[n] = height > 0 ? value : infinity;
    }
    std::array<float, lanes> sums{};
    for (std::size_t n = 0; n < count_.outside; n += lanes) {
        for (std::size_t k = 0; k < lanes; ++k) sums[k] += ratio[n + k];
    }
    return double{sums[0]} + sums[1] + (double{sums[2]} + sums[3]);
}

// A circumcentre moves along the axis by the component of the movement towards it, over the height.
ANATOMESH_CLONES double StarRatios::sum(Vec3 move, Vec3& gradient) const {
    const auto x = static_cast<float>(move.x), y = static_cast<float>(move.y), z = static_cast<float>(move.z);
    constexpr float infinity = std::numeric_limits<float>::infinity();
    Row ratio;
    Rows slope;
    for (std::size_t n = 0; n < count_.outside; ++n) {
        const float dx = x - center_.x[n], dy = y - center_.y[n], dz = z - center_.z[n];
        const float height = normal_.x[n] * x + normal_.y[n] * y + normal_.z[n] * z + height_[n];
        const float t = (dx * dx + dy * dy + dz * dz - squared_radius_[n]) / (2 * height);
        const float ax = x - p_.x[n], ay = y - p_.y[n], az = z - p_.z[n];
        const float bx = x - q_.x[n], by = y - q_.y[n], bz = z - q_.z[n];
        const float cx = x - r_.x[n], cy = y - r_.y[n], cz = z - r_.z[n];
        const float a2 = ax * ax + ay * ay + az * az, b2 = bx * bx + by * by + bz * bz,
                    c2 = cx * cx + cy * cy + cz * cz;
        const bool is_b = b2 < a2;
        const float ab = is_b ? b2 : a2;
        const float sx = is_b ? bx : ax, sy = is_b ? by : ay, sz = is_b ? bz : az;
        const bool is_c = c2 < ab;
        const float abc = is_c ? c2 : ab;
        const float tx = is_c ? cx : sx, ty = is_c ? cy : sy, tz = is_c ? cz : sz;
        const bool moves = abc < squared_shortest_[n];
        const float shortest = moves ? abc : squared_shortest_[n];
        const float squared = squared_radius_[n] + t * t;
        const float value = std::sqrt(squared / shortest);
        const float along = value * t / (squared * height);
        const float beside = moves ? value / shortest : 0.0f;
        ratio[n] = height > 0 ? value : infinity;
        slope.x[n] = along * (dx - t * normal_.x[n]) - beside * tx;
        slope.y[n] = along * (dy - t * normal_.y[n]) - beside * ty;
        slope.z[n] = along * (dz - t * normal_.z[n]) - beside * tz;
    }
    std::array<float, lanes> sums{}, sx{}, sy{}, sz{};
    for (std::size_t n = 0; n < count_.outside; n += lanes) {
        for (std::size_t k = 0; k < lanes; ++k) {
            sums[k] += ratio[n + k];
            sx[k] += slope.x[n + k];
            sy[k] += slope.y[n + k];
            sz[k] += slope.z[n + k];
        }
    }
    const auto total = [](const std::array<float, lanes>& s) {
        return double{s[0]} + s[1] + (double{s[2]} + s[3]);
    };
    gradient = {total(sx), total(sy), total(sz)};
    return total(sums);
}

// The measures of a cell (v, a, b, c), with vectors to its vertices from v.
ANATOMESH_CLONES StarRatios::Worst StarRatios::worst(Vec3 move) const {
    const auto x = static_cast<float>(move.x), y = static_cast<float>(move.y), z = static_cast<float>(move.z);
    Row flatness, ratio, sine;
    for (std::size_t n = 0; n < count_.end; ++n) {
        const float ax = p_.x[n] - x, ay = p_.y[n] - y, az = p_.z[n] - z;
        const float bx = q_.x[n] - x, by = q_.y[n] - y, bz = q_.z[n] - z;
        const float cx = r_.x[n] - x, cy = r_.y[n] - y, cz = r_.z[n] - z;
        const float a2 = ax * ax + ay * ay + az * az, b2 = bx * bx + by * by + bz * bz,
                    c2 = cx * cx + cy * cy + cz * cz;
        const float height = normal_.x[n] * x + normal_.y[n] * y + normal_.z[n] * z + height_[n];
        const float ab = a2 < b2 ? b2 : a2, cf = c2 < squared_longest_[n] ? squared_longest_[n] : c2;
        const float longest = ab < cf ? cf : ab;
        flatness[n] = height * twice_area_[n] / (longest * std::sqrt(longest));
    }
    for (std::size_t n = 0; n < count_.outside; ++n) {
        const float ax = p_.x[n] - x, ay = p_.y[n] - y, az = p_.z[n] - z;
        const float bx = q_.x[n] - x, by = q_.y[n] - y, bz = q_.z[n] - z;
        const float cx = r_.x[n] - x, cy = r_.y[n] - y, cz = r_.z[n] - z;
        const float a2 = ax * ax + ay * ay + az * az, b2 = bx * bx + by * by + bz * bz,
                    c2 = cx * cx + cy * cy + cz * cz;
        const float dx = x - center_.x[n], dy = y - center_.y[n], dz = z - center_.z[n];
        const float height = normal_.x[n] * x + normal_.y[n] * y + normal_.z[n] * z + height_[n];
        const float t = (dx * dx + dy * dy + dz * dz - squared_radius_[n]) / (2 * height);
        const float ab = a2 < b2 ? a2 : b2, cf = c2 < squared_shortest_[n] ? c2 : squared_shortest_[n];
        ratio[n] = (squared_radius_[n] + t * t) / (ab < cf ? ab : cf);
    }
    for (std::size_t n = 0; n < count_.outside; ++n) {
        const float ax = p_.x[n] - x, ay = p_.y[n] - y, az = p_.z[n] - z;
        const float bx = q_.x[n] - x, by = q_.y[n] - y, bz = q_.z[n] - z;
        const float cx = r_.x[n] - x, cy = r_.y[n] - y, cz = r_.z[n] - z;
        const float a2 = ax * ax + ay * ay + az * az, b2 = bx * bx + by * by + bz * bz,
                    c2 = cx * cx + cy * cy + cz * cz;
        const float ex = bx - ax, ey = by - ay, ez = bz - az, fx = cx - ax, fy = cy - ay, fz = cz - az,
                    gx = cx - bx, gy = cy - by, gz = cz - bz;
        const float ab2 = ex * ex + ey * ey + ez * ez, ac2 = fx * fx + fy * fy + fz * fz,
                    bc2 = gx * gx + gy * gy + gz * gz;
        const float ux = by * cz - bz * cy, uy = bz * cx - bx * cz, uz = bx * cy - by * cx;
        const float vx = cy * az - cz * ay, vy = cz * ax - cx * az, vz = cx * ay - cy * ax;
        const float wx = ay * bz - az * by, wy = az * bx - ax * bz, wz = ax * by - ay * bx;
        const float f0 = twice_area_[n] * twice_area_[n], fa = ux * ux + uy * uy + uz * uz,
                    fb = vx * vx + vy * vy + vz * vz, fc = wx * wx + wy * wy + wz * wz;
        const float height = normal_.x[n] * x + normal_.y[n] * y + normal_.z[n] * z + height_[n];
        // |n_k| |n_l| sin = 6 volume |edge|, n_k and n_l the normals of the facets at the edge; the product
        // of all four over that of the other two.
        const float at_a = a2 * f0 * fa, at_b = b2 * f0 * fb, at_c = c2 * f0 * fc;
        const float at_ab = ab2 * fa * fb, at_ac = ac2 * fa * fc, at_bc = bc2 * fb * fc;
        const float least_1 = at_a < at_b ? at_a : at_b, least_2 = at_c < at_ab ? at_c : at_ab,
                    least_3 = at_ac < at_bc ? at_ac : at_bc;
        const float least_4 = least_1 < least_2 ? least_1 : least_2;
        const float least = least_3 < least_4 ? least_3 : least_4;
        sine[n] = height * height / (fa * fb * fc) * least;
    }
    Worst worst{0, 1, 1};
    for (std::size_t n = 0; n < count_.end; ++n) {
        if (n >= count_.inside && n < count_.outside) continue;
        if (!(flatness[n] >= worst.flattest)) worst.flattest = flatness[n];
    }
    for (std::size_t n = 0; n < count_.inside; ++n) {
        if (!(ratio[n] <= worst.squared_ratio)) worst.squared_ratio = ratio[n];
        if (!(sine[n] >= worst.squared_sine)) worst.squared_sine = sine[n];
    }
    return worst;
}

StarRatios::Verdict StarRatios::judge(Vec3 move, double max_ratio, double min_sine) const {
    const Worst now = worst(move);
    if (!(now.flattest >= 2 * nearly_flat_shape)) return Verdict::unsure;
    auto squared_ratio = static_cast<float>(max_ratio * max_ratio),
         squared_sine = static_cast<float>(min_sine * min_sine);
    const auto good = [&] {
        return now.squared_ratio * surely <= squared_ratio && now.squared_sine >= squared_sine * surely;
    };
    if (good()) return Verdict::good;
    const Worst before = worst({});
    squared_ratio = std::max(squared_ratio, before.squared_ratio);
    squared_sine = std::min(squared_sine, before.squared_sine);
    if (good()) return Verdict::good;
    const bool bad = now.squared_ratio > squared_ratio * surely || now.squared_sine * surely < squared_sine;
    return bad ? Verdict::bad : Verdict::unsure;
}

}  // namespace anatomesh
