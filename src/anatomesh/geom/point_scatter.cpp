#include "anatomesh/geom/point_scatter.h"

#include <array>
#include <cmath>
#include <cstddef>

namespace anatomesh {

Vec3 canonical(Vec3 normal) {
    const double ax = std::abs(normal.x), ay = std::abs(normal.y), az = std::abs(normal.z);
    const double leading = az >= ax && az >= ay ? normal.z : ay >= ax ? normal.y : normal.x;
    return leading < 0 ? -normal : normal;
}

// Eight sweeps are more than a 3 x 3 matrix needs for full precision.
Vec3 least_direction(const Scatter& s) {
    std::array<std::array<double, 3>, 3> a{{{s.xx, s.xy, s.xz}, {s.xy, s.yy, s.yz}, {s.xz, s.yz, s.zz}}};
    std::array<std::array<double, 3>, 3> v{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    for (int sweep = 0; sweep < 8; ++sweep) {
        for (int p = 0; p < 2; ++p) {
            for (int q = p + 1; q < 3; ++q) {
                if (a[p][q] == 0) continue;
                const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
                const double t = (theta >= 0 ? 1 : -1) / (std::abs(theta) + std::sqrt(theta * theta + 1));
                const double c = 1 / std::sqrt(t * t + 1), sine = t * c;
                for (int k = 0; k < 3; ++k) {
                    const double kp = a[k][p], kq = a[k][q];
                    a[k][p] = c * kp - sine * kq, a[k][q] = sine * kp + c * kq;
                }
                for (int k = 0; k < 3; ++k) {
                    const double pk = a[p][k], qk = a[q][k];
                    a[p][k] = c * pk - sine * qk, a[q][k] = sine * pk + c * qk;
                    const double kp = v[k][p], kq = v[k][q];
                    v[k][p] = c * kp - sine * kq, v[k][q] = sine * kp + c * kq;
                }
            }
        }
    }
    int least = 2;
    for (int k = 1; k >= 0; --k) {
        if (a[k][k] < a[least][least]) least = k;
    }
    return canonical(normalized(Vec3{v[0][least], v[1][least], v[2][least]}));
}

Vec3 mean_of(std::span<const Vec3> points) {
    Vec3 mean;
    for (const Vec3& p : points) mean += p - points[0];
    return points[0] + (1.0 / static_cast<double>(points.size())) * mean;
}

Scatter scatter_of(std::span<const Vec3> points) {
    const Vec3 mean = mean_of(points);
    Scatter scatter;
    for (const Vec3& p : points) scatter.add(p - mean);
    return scatter;
}

double vector_area(std::span<const Vec3> points) {
    Vec3 sum;
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
        sum += cross(points[i] - points[0], points[i + 1] - points[0]);
    }
    return 0.5 * length(sum);
}

}  // namespace anatomesh
