// The predicates are signs of determinants: their laws, and every sign against exact rational arithmetic.
#include "anatomesh/geom/predicates.h"

#include <gtest/gtest.h>

#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <cstdlib>
#include <random>

namespace anatomesh::predicates_test {
namespace {

using Integer = boost::multiprecision::cpp_int;

// How often a law is tried; forty times as often, ten million calls in all, when ANATOMESH_THOROUGH is set.
int times(int count) {
    return std::getenv("ANATOMESH_THOROUGH") ? 40 * count : count;
}

// Differences of doubles as integers, all scaled by the same power of two: exact, and quicker than fractions.
// Requires: magnitudes of nonzero coordinates within 2^400 of each other.
class Scaled {
  public:
    template <std::size_t n>
    explicit Scaled(const std::array<double, n>& values) {
        for (const double v : values) {
            if (v != 0) least_ = std::min(least_, std::ilogb(v) - 60);
        }
    }
    Integer operator()(double value) const {
        if (value == 0) return 0;
        int exponent = 0;
        const double fraction = std::frexp(value, &exponent);
        Integer whole = static_cast<std::int64_t>(std::ldexp(fraction, 53));
        whole <<= exponent - 53 - least_;
        return whole;
    }

  private:
    int least_ = 2000;
};

int sign(const Integer& x) {
    return x.sign();
}

int exact_orient2d(Vec2 a, Vec2 b, Vec2 c) {
    const Scaled s(std::array{a.x, a.y, b.x, b.y, c.x, c.y});
    return sign((s(b.x) - s(a.x)) * (s(c.y) - s(a.y)) - (s(b.y) - s(a.y)) * (s(c.x) - s(a.x)));
}

using Row = std::array<Integer, 3>;

Integer determinant(const Row& p, const Row& q, const Row& r) {
    return p[0] * (q[1] * r[2] - q[2] * r[1]) - p[1] * (q[0] * r[2] - q[2] * r[0]) +
           p[2] * (q[0] * r[1] - q[1] * r[0]);
}

int exact_orient3d(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    const Scaled s(std::array{a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, d.x, d.y, d.z});
    const auto row = [&](Vec3 p) { return Row{s(p.x) - s(a.x), s(p.y) - s(a.y), s(p.z) - s(a.z)}; };
    return sign(determinant(row(b), row(c), row(d)));
}

// Positive when e is inside the sphere of the positive cell: by the lifted determinant.
int exact_in_sphere(Vec3 a, Vec3 b, Vec3 c, Vec3 d, Vec3 e) {
    const Scaled s(std::array{a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, d.x, d.y, d.z, e.x, e.y, e.z});
    const auto row = [&](Vec3 p) { return Row{s(p.x) - s(e.x), s(p.y) - s(e.y), s(p.z) - s(e.z)}; };
    const auto lift = [](const Row& r) { return Integer(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]); };
    const Row p = row(a), q = row(b), r = row(c), t = row(d);
    return sign(lift(p) * determinant(q, r, t) - lift(q) * determinant(p, r, t) +
                lift(r) * determinant(p, q, t) - lift(t) * determinant(p, q, r));
}

double nudged(double x, std::mt19937& random) {
    switch (random() % 3) {
        case 0:
            return std::nextafter(x, INFINITY);
        case 1:
            return std::nextafter(x, -INFINITY);
        default:
            return x;
    }
}

Vec3 nudged(Vec3 p, std::mt19937& random) {
    return {nudged(p.x, random), nudged(p.y, random), nudged(p.z, random)};
}

// M-04: rounded to the plane, then moved by at most one last place.
TEST(Predicates, M04_orient2d_agrees_with_exact_arithmetic_next_to_a_line) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> coordinate(-100, 100);
    int zeros = 0;
    for (int n = 0; n < times(100000); ++n) {
        const Vec2 a{coordinate(random), coordinate(random)}, b{coordinate(random), coordinate(random)};
        const double t = coordinate(random);
        Vec2 c = a + t * (b - a);
        c = {nudged(c.x, random), nudged(c.y, random)};
        const int found = orient2d(a, b, c);
        ASSERT_EQ(found, exact_orient2d(a, b, c));
        zeros += found == 0;
        ASSERT_EQ(orient2d(b, c, a), found);
        ASSERT_EQ(orient2d(b, a, c), -found);
    }
    EXPECT_LT(zeros, times(50000));
}

TEST(Predicates, M04_orient3d_agrees_with_exact_arithmetic_next_to_a_plane) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> coordinate(-100, 100), share(-1, 2);
    for (int n = 0; n < times(100000); ++n) {
        const Vec3 a{coordinate(random), coordinate(random), coordinate(random)};
        const Vec3 b{coordinate(random), coordinate(random), coordinate(random)};
        const Vec3 c{coordinate(random), coordinate(random), coordinate(random)};
        const Vec3 d = nudged(a + share(random) * (b - a) + share(random) * (c - a), random);
        const int found = orient3d(a, b, c, d);
        ASSERT_EQ(found, exact_orient3d(a, b, c, d));
        ASSERT_EQ(orient3d(b, a, c, d), -found);
        ASSERT_EQ(orient3d(b, c, a, d), found);
        ASSERT_EQ(orient3d(d, c, b, a), found);
    }
}

TEST(Predicates, M04_in_sphere_agrees_with_exact_arithmetic_next_to_a_sphere) {
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    const auto on_sphere = [&] {
        return nudged(Vec3{1, 2, 3} + 50 * normalized({normal(random), normal(random), normal(random)}),
                      random);
    };
    int tested = 0;
    for (int n = 0; n < times(40000); ++n) {
        Vec3 a = on_sphere(), b = on_sphere();
        const Vec3 c = on_sphere(), d = on_sphere(), e = on_sphere();
        const int turn = orient3d(a, b, c, d);
        if (turn == 0) continue;
        if (turn < 0) std::swap(a, b);
        const int found = in_sphere(a, b, c, d, e);
        ASSERT_EQ(found, exact_in_sphere(a, b, c, d, e));
        ASSERT_EQ(in_sphere(b, c, a, d, e), found);
        ASSERT_EQ(in_sphere(b, a, d, c, e), found);
        ++tested;
    }
    EXPECT_GT(tested, times(39000));
}

TEST(Predicates, small_integers_are_zero_exactly_when_degenerate) {
    std::mt19937 random(4);
    std::uniform_int_distribution<int> digit(-2, 2);
    int zeros3 = 0, zeros_sphere = 0;
    for (int n = 0; n < 20000; ++n) {
        const auto point = [&] {
            return Vec3{double(digit(random)), double(digit(random)), double(digit(random))};
        };
        Vec3 a = point(), b = point();
        const Vec3 c = point(), d = point(), e = point();
        const int turn = orient3d(a, b, c, d);
        ASSERT_EQ(turn, exact_orient3d(a, b, c, d));
        zeros3 += turn == 0;
        if (turn == 0) continue;
        if (turn < 0) std::swap(a, b);
        ASSERT_EQ(in_sphere(a, b, c, d, e), exact_in_sphere(a, b, c, d, e));
        zeros_sphere += in_sphere(a, b, c, d, e) == 0;
    }
    EXPECT_GT(zeros3, 1000);
    EXPECT_GT(zeros_sphere, 500);
}

TEST(Predicates, the_sign_convention) {
    EXPECT_EQ(orient2d({0, 0}, {1, 0}, {0, 1}), 1);
    EXPECT_EQ(orient3d({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}), 1);
    EXPECT_EQ(in_sphere({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.5, 0.5, 0.5}), 1);
    EXPECT_EQ(in_sphere({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}), 0);
    EXPECT_EQ(in_sphere({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1.0000001}), -1);
}

// Products of small differences leave the range of doubles long before the differences do.
TEST(Predicates, exact_also_where_products_underflow_or_overflow) {
    std::mt19937 random(5);
    std::uniform_int_distribution<int> digit(-3, 3);
    for (const int exponent : {-350, -357, -358, -359, -400, -530, -537, -1070, 300, 350, 600}) {
        for (int n = 0; n < 2000; ++n) {
            const auto point = [&] {
                return Vec3{std::ldexp(digit(random), exponent), std::ldexp(digit(random), exponent),
                            std::ldexp(digit(random), exponent)};
            };
            const Vec3 a = point(), b = point(), c = point(), d = point();
            ASSERT_EQ(orient2d({a.x, a.y}, {b.x, b.y}, {c.x, c.y}),
                      exact_orient2d({a.x, a.y}, {b.x, b.y}, {c.x, c.y}))
                << exponent;
            ASSERT_EQ(orient3d(a, b, c, d), exact_orient3d(a, b, c, d)) << exponent;
        }
    }
}

TEST(Predicates, M04_exact_for_random_points_whose_products_underflow) {
    std::mt19937 random(6);
    std::uniform_real_distribution<double> coordinate(-1, 1), share(-1, 2);
    for (const int exponent : {-345, -352, -356, -358, -360, -530, -536, -538}) {
        for (int n = 0; n < 3000; ++n) {
            const auto point = [&] {
                return Vec3{std::ldexp(coordinate(random), exponent),
                            std::ldexp(coordinate(random), exponent),
                            std::ldexp(coordinate(random), exponent)};
            };
            const Vec3 a = point(), b = point(), c = point();
            const Vec3 d = nudged(a + share(random) * (b - a) + share(random) * (c - a), random);
            const Vec2 e = {a.x, a.y}, f = {b.x, b.y};
            const Vec2 g = e + share(random) * (f - e);
            ASSERT_EQ(orient2d(e, f, g), exact_orient2d(e, f, g)) << exponent;
            ASSERT_EQ(orient3d(a, b, c, d), exact_orient3d(a, b, c, d)) << exponent;
        }
    }
}

// The same near a sphere, where products of five overflow or underflow, and far apart in magnitude.
TEST(Predicates, M04_in_sphere_is_exact_at_any_scale) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    for (const int exponent :
         {-1060, -540, -300, -213, -205, -200, -160, -145, 100, 190, 205, 340, 600, 1000}) {
        for (int n = 0; n < times(400); ++n) {
            const auto on_sphere = [&] {
                const Vec3 p =
                    nudged(3.0 * normalized({normal(random), normal(random), normal(random)}), random);
                return Vec3{std::ldexp(p.x, exponent), std::ldexp(p.y, exponent), std::ldexp(p.z, exponent)};
            };
            Vec3 a = on_sphere(), b = on_sphere();
            const Vec3 c = on_sphere(), d = on_sphere(), e = on_sphere();
            const int turn = orient3d(a, b, c, d);
            ASSERT_EQ(turn, exact_orient3d(a, b, c, d));
            if (turn == 0) continue;
            if (turn < 0) std::swap(a, b);
            ASSERT_EQ(in_sphere(a, b, c, d, e), exact_in_sphere(a, b, c, d, e)) << exponent;
        }
    }
    std::uniform_int_distribution<int> exponents(-160, 160);
    for (int n = 0; n < times(3000); ++n) {
        const auto point = [&] {
            return Vec3{std::ldexp(normal(random), exponents(random)),
                        std::ldexp(normal(random), exponents(random)),
                        std::ldexp(normal(random), exponents(random))};
        };
        const Vec3 a = point(), b = point(), c = point(), d = point(), e = point();
        ASSERT_EQ(orient3d(a, b, c, d), exact_orient3d(a, b, c, d));
        ASSERT_EQ(in_sphere(a, b, c, d, e), exact_in_sphere(a, b, c, d, e));
    }
}

// Whole numbers of 20 bits: cospherical to the last digit or next to it, as pixels are.
TEST(Predicates, M04_in_sphere_agrees_with_exact_arithmetic_on_a_grid) {
    std::mt19937 random(8);
    std::normal_distribution<double> normal;
    int zeros = 0;
    for (const double radius : {3.0, 30.0, 500000.0}) {
        for (int n = 0; n < times(10000); ++n) {
            const auto point = [&] {
                const Vec3 p = radius * normalized({normal(random), normal(random), normal(random)});
                return Vec3{std::round(p.x), std::round(p.y), std::round(p.z)};
            };
            Vec3 a = point(), b = point();
            const Vec3 c = point(), d = point(), e = point();
            if (orient3d(a, b, c, d) < 0) std::swap(a, b);
            const int found = in_sphere(a, b, c, d, e);
            ASSERT_EQ(found, exact_in_sphere(a, b, c, d, e));
            zeros += found == 0;
        }
    }
    EXPECT_GT(zeros, times(100));
}

// Ties are decided, one way for every even order of the cell, and a vertex is never in its own cell's sphere.
TEST(Predicates, perturbed_spheres_have_no_ties) {
    std::mt19937 random(9);
    std::uniform_int_distribution<int> digit(-1, 1);
    int ties = 0;
    for (int n = 0; n < times(20000); ++n) {
        const auto point = [&] {
            return Vec3{double(digit(random)), double(digit(random)), double(digit(random))};
        };
        Vec3 a = point(), b = point();
        const Vec3 c = point(), d = point(), e = point();
        const int turn = orient3d(a, b, c, d);
        if (turn == 0) continue;
        if (turn < 0) std::swap(a, b);
        const int found = in_perturbed_sphere(a, b, c, d, e);
        ASSERT_EQ(std::abs(found), 1);
        if (const int exact = in_sphere(a, b, c, d, e)) {
            ASSERT_EQ(found, exact);
        } else {
            ++ties;
        }
        ASSERT_EQ(in_perturbed_sphere(b, c, a, d, e), found);
        ASSERT_EQ(in_perturbed_sphere(b, a, d, c, e), found);
        for (const Vec3& vertex : {a, b, c, d}) ASSERT_EQ(in_perturbed_sphere(a, b, c, d, vertex), -1);
    }
    EXPECT_GT(ties, times(1000));
}

}  // namespace
}  // namespace anatomesh::predicates_test
