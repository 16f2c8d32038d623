#include "anatomesh/measure/field_difference.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <string>

#include "anatomesh/base/parallel.h"
#include "anatomesh/geom/predicates.h"
#include "anatomesh/measure/hausdorff.h"

namespace anatomesh {

namespace {

constexpr double most_points = 100'000;  // A lattice has no more. [points; >= 1; B]
// A thread takes so many columns of the lattice at a time. [columns; >= 1; B]
constexpr std::size_t columns_at_a_time = 64;
// The tangent of the lattice's angle is the number that fractions approximate worst. [1; 0 to 1; D golden ratio]
constexpr double golden = 0.6180339887498949;

// Columns along z over a box: a square lattice, turned.
class Columns {
  public:
    Columns(const Box3& box, double step) : box_(box), step_(step) {
        const double cosine = 1 / std::sqrt(1 + golden * golden);
        u_ = {cosine, golden * cosine};
        const Vec3 size = box.high - box.low;
        reach_ = static_cast<std::int64_t>(0.5 * std::hypot(size.x, size.y) / step) + 1;
        centre_ = {0.5 * (box.low.x + box.high.x), 0.5 * (box.low.y + box.high.y)};
        side_ = static_cast<std::size_t>(2 * reach_ + 1);
        for (std::size_t n = 0; n < side_ * side_; ++n) {
            const Vec2 at = place(n);
            const bool inside =
                at.x >= box.low.x && at.x <= box.high.x && at.y >= box.low.y && at.y <= box.high.y;
            number_.push_back(inside ? static_cast<std::uint32_t>(columns_.size()) : no_cell);
            if (inside) columns_.push_back(at);
        }
        levels_ = static_cast<std::size_t>(size.z / step) + 1;
    }

    std::size_t size() const { return columns_.size(); }
    std::size_t levels() const { return levels_; }
    Vec2 operator[](std::size_t n) const { return columns_[n]; }
    double height(std::size_t level) const { return box_.low.z + (static_cast<double>(level) + 0.5) * step_; }
    // The lowest level at z or above it.
    std::size_t level_above(double z) const {
        const double level = std::ceil((z - box_.low.z) / step_ - 0.5);
        return static_cast<std::size_t>(std::clamp(level, 0.0, static_cast<double>(levels_)));
    }

    // Calls visit(column) for the columns in the rectangle, and maybe some beside it.
    template <class Visit>
    void for_each_in(Vec2 low, Vec2 high, const Visit& visit) const {
        // The lattice's coordinates of the corners bound those of the points.
        double least_i = HUGE_VAL, most_i = -HUGE_VAL, least_j = HUGE_VAL, most_j = -HUGE_VAL;
        for (const Vec2 corner : {low, high, Vec2{low.x, high.y}, Vec2{high.x, low.y}}) {
            const Vec2 d = corner - centre_;
            const double i = (d.x * u_.x + d.y * u_.y) / step_, j = (d.y * u_.x - d.x * u_.y) / step_;
            least_i = std::min(least_i, i);
            most_i = std::max(most_i, i);
            least_j = std::min(least_j, j);
            most_j = std::max(most_j, j);
        }
        const auto first = [&](double least) {
            return std::max(-reach_, static_cast<std::int64_t>(std::floor(least)));
        };
        const auto last = [&](double most) {
            return std::min(reach_, static_cast<std::int64_t>(std::ceil(most)));
        };
        for (std::int64_t j = first(least_j); j <= last(most_j); ++j) {
            for (std::int64_t i = first(least_i); i <= last(most_i); ++i) {
                const std::uint32_t n = number_[static_cast<std::size_t>(j + reach_) * side_ +
                                                static_cast<std::size_t>(i + reach_)];
                if (n != no_cell) visit(n);
            }
        }
    }

  private:
    Vec2 place(std::size_t n) const {
        const double i = static_cast<double>(static_cast<std::int64_t>(n % side_) - reach_);
        const double j = static_cast<double>(static_cast<std::int64_t>(n / side_) - reach_);
        return centre_ + (i * step_) * u_ + (j * step_) * Vec2{-u_.y, u_.x};
    }

    Box3 box_;
    double step_;
    Vec2 u_, centre_;
    std::int64_t reach_ = 0;
    std::size_t side_ = 0, levels_ = 0;
    std::vector<Vec2> columns_;
    std::vector<std::uint32_t> number_;  // of the column at a place of the lattice
};

Vec2 flat(Vec3 p) {
    return {p.x, p.y};
}

// Of q moved by (e, e * e), e as small as may be. Requires: a and b differ.
int side_of_line(Vec2 a, Vec2 b, Vec2 q) {
    if (const int side = orient2d(a, b, q); side != 0) return side;
    return a.y != b.y ? (a.y < b.y ? -1 : 1) : (a.x < b.x ? 1 : -1);
}

// Whether the column through q meets the triangle; then at what height.
bool meets(Vec3 a, Vec3 b, Vec3 c, Vec2 q, double& z) {
    const Vec2 p0 = flat(a), p1 = flat(b), p2 = flat(c);
    if (orient2d(p0, p1, p2) == 0) return false;
    const int side = side_of_line(p0, p1, q);
    if (side_of_line(p1, p2, q) != side || side_of_line(p2, p0, q) != side) return false;
    const auto doubled_area = [](Vec2 r, Vec2 s, Vec2 t) {
        return (s.x - r.x) * (t.y - r.y) - (s.y - r.y) * (t.x - r.x);
    };
    const double wa = doubled_area(p1, p2, q), wb = doubled_area(p2, p0, q), wc = doubled_area(p0, p1, q);
    const double sum = wa + wb + wc;
    z = sum != 0 ? (wa * a.z + wb * b.z + wc * c.z) / sum : a.z;
    z = std::clamp(z, std::min({a.z, b.z, c.z}), std::max({a.z, b.z, c.z}));
    return true;
}

struct Differing {
    Vec3 at;
    bool in_field = false;
};

// One structure's surface beside the field.
class Comparison {
  public:
    Comparison(std::span<const Vec3> points, const std::vector<Triangle>& surface,
               const StructureField& field, std::uint32_t of_field, Vec3 origin, double points_at_most)
        : points_(points),
          surface_(surface),
          field_(field),
          of_field_(of_field),
          origin_(origin),
          box_(box_of(points, surface, field, of_field, origin)),
          columns_(box_, step_of(points_at_most)) {}

    std::size_t points() const { return columns_.size() * columns_.levels(); }

    std::vector<Differing> differing(int threads) const {
        const std::vector<std::uint8_t> crossed = crossings();
        return parallel_collect<Differing>(
            columns_.size(), columns_at_a_time, threads,
            [&](std::size_t begin, std::size_t end, std::vector<Differing>& out) {
                std::vector<std::uint32_t> members;
                for (std::size_t n = begin; n < end; ++n) {
                    bool in_model = false;
                    for (std::size_t k = 0; k < columns_.levels(); ++k) {
                        in_model ^= crossed[n * (columns_.levels() + 1) + k] != 0;
                        const Vec3 p{columns_[n].x, columns_[n].y, columns_.height(k)};
                        field_.members(p - origin_, members);
                        const bool in_field = std::binary_search(members.begin(), members.end(), of_field_);
                        if (in_field != in_model) out.push_back({p, in_field});
                    }
                }
            });
    }

  private:
    static Box3 box_of(std::span<const Vec3> points, const std::vector<Triangle>& surface,
                       const StructureField& field, std::uint32_t of_field, Vec3 origin) {
        const Box3 of_structure = field.box_of(of_field);
        Box3 box;
        if (!of_structure.empty()) box = {of_structure.low + origin, of_structure.high + origin};
        for (const Triangle& t : surface) {
            for (const std::uint32_t v : t) box.extend(points[v]);
        }
        return box;
    }

    // The mean length of the edges, or longer.
    double step_of(double points_at_most) const {
        double sum = 0;
        for (const Triangle& t : surface_) sum += length(points_[t[1]] - points_[t[0]]);
        const double mean = sum / static_cast<double>(std::max<std::size_t>(surface_.size(), 1));
        const Vec3 size = box_.high - box_.low;
        return std::max(mean, std::cbrt(size.x * size.y * size.z / points_at_most));
    }

    // By column and level: whether the facets between this level and the one below are odd in number.
    std::vector<std::uint8_t> crossings() const {
        std::vector<std::uint8_t> crossed(columns_.size() * (columns_.levels() + 1));
        for (const Triangle& t : surface_) {
            const Vec3 a = points_[t[0]], b = points_[t[1]], c = points_[t[2]];
            const Vec2 low{std::min({a.x, b.x, c.x}), std::min({a.y, b.y, c.y})};
            const Vec2 high{std::max({a.x, b.x, c.x}), std::max({a.y, b.y, c.y})};
            columns_.for_each_in(low, high, [&](std::uint32_t n) {
                if (double z = 0; meets(a, b, c, columns_[n], z))
                    crossed[n * (columns_.levels() + 1) + columns_.level_above(z)] ^= 1;
            });
        }
        return crossed;
    }

    std::span<const Vec3> points_;
    const std::vector<Triangle>& surface_;
    const StructureField& field_;
    std::uint32_t of_field_;
    Vec3 origin_;
    Box3 box_;
    Columns columns_;
};

// With the points that it uses alone.
SurfaceMesh surface_of(std::span<const Vec3> points, const std::vector<Triangle>& triangles) {
    SurfaceMesh surface;
    surface.triangles = triangles;
    std::vector<std::uint32_t> number(points.size(), no_cell);
    for (Triangle& t : surface.triangles) {
        for (std::uint32_t& v : t) {
            if (number[v] == no_cell) {
                number[v] = static_cast<std::uint32_t>(surface.points.size());
                surface.points.push_back(points[v]);
            }
            v = number[v];
        }
    }
    return surface;
}

}  // namespace

FieldDifferenceReport field_difference(std::span<const Vec3> points,
                                       const std::vector<std::vector<Triangle>>& surfaces,
                                       std::span<const Structure> structures,
                                       std::span<const std::uint32_t> of_field, const StructureField& field,
                                       Vec3 origin, int threads) {
    assert(surfaces.size() == of_field.size() && structures.size() == of_field.size());
    FieldDifferenceReport report;
    const auto drawn =
        std::count_if(of_field.begin(), of_field.end(), [](std::uint32_t s) { return s != no_cell; });
    const double points_each =
        most_points / std::sqrt(static_cast<double>(std::max<std::ptrdiff_t>(drawn, 1)));
    for (std::uint32_t s = 0; s < surfaces.size(); ++s) {
        if (of_field[s] == no_cell || surfaces[s].empty()) continue;
        const Comparison comparison(points, surfaces[s], field, of_field[s], origin, points_each);
        const std::vector<Differing> differing = comparison.differing(threads);
        report.points += comparison.points();
        report.differing += differing.size();
        if (differing.empty()) continue;
        const SurfaceMesh surface = surface_of(points, surfaces[s]);
        const ClosestPoint closest(surface);
        std::vector<double> distances(differing.size());
        parallel_for(differing.size(), 256, threads, [&](std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) distances[n] = closest.distance(differing[n].at);
        });
        const auto farthest =
            std::max_element(distances.begin(), distances.end());  // the first of equal ones
        if (*farthest <= report.max_mm) continue;
        const Differing& point = differing[static_cast<std::size_t>(farthest - distances.begin())];
        report.max_mm = *farthest;
        report.at = {point.at.x, point.at.y, point.at.z};
        report.missing = point.in_field;
        report.structure =
            structures[s].name.empty() ? std::to_string(structures[s].number) : structures[s].name;
    }
    return report;
}

}  // namespace anatomesh
