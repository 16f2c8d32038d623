#include "anatomesh/geom/predicates_exact.h"

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace anatomesh::exact {

namespace {

// ---- Expansions ----

// A double and the rounding error of the operation that made it; together exact.
struct Pair {
    double high, low;
};

Pair two_sum(double a, double b) {
    const double sum = a + b, b_part = sum - a, a_part = sum - b_part;
    return {sum, (a - a_part) + (b - b_part)};
}

// Requires: |a| >= |b|, or a == 0.
Pair fast_two_sum(double a, double b) {
    const double sum = a + b;
    return {sum, b - (sum - a)};
}

// The upper and the lower half of the digits of a double (Veltkamp, Dekker).
Pair split(double a) {
    const double c = 0x1.0000002p27 * a, high = c - (c - a);
    return {high, a - high};
}

Pair two_product(double a, double b, Pair b_halves) {
    const double product = a * b;
    const Pair halves = split(a);
    const double error =
        ((product - halves.high * b_halves.high) - halves.low * b_halves.high) - halves.high * b_halves.low;
    return {product, halves.low * b_halves.low - error};
}

// No expansion here is longer. Every part holds one of the binary digits between the smallest and the largest that a
// determinant of degree five has when the coordinates are in range. [parts; > 0; D]
constexpr int most_parts = 2048;

// A sum of doubles that do not overlap, in order of increasing magnitude, none of them zero; empty is zero.
// Its sign is that of the last.
template <int capacity>
struct Expansion {
    static_assert(capacity <= most_parts);
    int size = 0;
    std::array<double, capacity> part;  // those before `size` are set

    Expansion() {}  // leaves the parts unset: they are many
    void push(double value) {
        if (value != 0) part[size++] = value;
    }
    int sign() const { return size == 0 ? 0 : part[size - 1] > 0 ? 1 : -1; }
};

constexpr int capped(int capacity) {
    return std::min(capacity, most_parts);
}

Expansion<2> difference(double a, double b) {
    Expansion<2> result;
    const Pair pair = two_sum(a, -b);
    result.push(pair.low);
    result.push(pair.high);
    return result;
}

// e + sign * f: the parts merged by magnitude, then summed from the smallest (Shewchuk, figure 8).
template <int m, int n>
Expansion<capped(m + n)> sum(const Expansion<m>& e, const Expansion<n>& f, double sign = 1) {
    Expansion<capped(m + n)> result;
    int i = 0, j = 0;
    const auto next = [&] {
        if (j == f.size || (i < e.size && std::abs(e.part[i]) < std::abs(f.part[j]))) return e.part[i++];
        return sign * f.part[j++];
    };
    const int count = e.size + f.size;
    if (count == 0) return result;
    double total = next();
    for (int k = 1; k < count; ++k) {
        const Pair pair = two_sum(total, next());
        result.push(pair.low);
        total = pair.high;
    }
    result.push(total);
    return result;
}

template <int m, int n>
auto minus(const Expansion<m>& e, const Expansion<n>& f) {
    return sum(e, f, -1);
}

// e * b (Shewchuk, figure 13).
template <int m>
Expansion<capped(2 * m)> scaled(const Expansion<m>& e, double b) {
    Expansion<capped(2 * m)> result;
    if (e.size == 0) return result;
    const Pair halves = split(b);
    Pair product = two_product(e.part[0], b, halves);
    result.push(product.low);
    double total = product.high;
    for (int i = 1; i < e.size; ++i) {
        product = two_product(e.part[i], b, halves);
        const Pair middle = two_sum(total, product.low);
        result.push(middle.low);
        const Pair top = fast_two_sum(product.high, middle.high);
        result.push(top.low);
        total = top.high;
    }
    result.push(total);
    return result;
}

template <int m, int n>
Expansion<capped(2 * m * n)> product(const Expansion<m>& e, const Expansion<n>& f) {
    Expansion<capped(2 * m * n)> result;
    for (int j = 0; j < f.size; ++j) {
        const auto grown = sum(result, scaled(e, f.part[j]));
        result.size = grown.size;
        std::copy_n(grown.part.begin(), grown.size, result.part.begin());
    }
    return result;
}

using Difference = Expansion<2>;

struct Row {
    Difference x, y, z;
};

Row row(Vec3 p, Vec3 origin) {
    return {difference(p.x, origin.x), difference(p.y, origin.y), difference(p.z, origin.z)};
}

// The determinant of the rows' x and y.
Expansion<16> minor_xy(const Row& p, const Row& q) {
    return minus(product(p.x, q.y), product(q.x, p.y));
}

// The determinant of three rows from their minors in x and y.
Expansion<192> determinant(const Row& p, const Row& q, const Row& r, const Expansion<16>& pq,
                           const Expansion<16>& qr, const Expansion<16>& pr) {
    return sum(minus(product(qr, p.z), product(pr, q.z)), product(pq, r.z));
}

Expansion<24> squared_length(const Row& p) {
    return sum(sum(product(p.x, p.x), product(p.y, p.y)), product(p.z, p.z));
}

// ---- Whole numbers of any length ----

using Integer = boost::multiprecision::cpp_int;

// Doubles as whole numbers, all scaled by the same power of two: so that the smallest has no fraction.
class Scale {
  public:
    template <std::size_t n>
    explicit Scale(const std::array<double, n>& values) {
        for (const double v : values) {
            if (v != 0) least_ = std::min(least_, std::ilogb(v) - 53);
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

using IntegerRow = std::array<Integer, 3>;

IntegerRow row(const Scale& scale, Vec3 p, Vec3 origin) {
    return {scale(p.x) - scale(origin.x), scale(p.y) - scale(origin.y), scale(p.z) - scale(origin.z)};
}

Integer determinant(const IntegerRow& p, const IntegerRow& q, const IntegerRow& r) {
    return p[0] * (q[1] * r[2] - q[2] * r[1]) - p[1] * (q[0] * r[2] - q[2] * r[0]) +
           p[2] * (q[0] * r[1] - q[1] * r[0]);
}

Integer squared_length(const IntegerRow& p) {
    return p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
}

// ---- Which of the two ----

// Whether no product of up to five differences of these can overflow, or lose a digit below the smallest double. This
// holds because 5 (-140 - 53) > -1022 and 5 (190 + 2) + 10 < 1023.
template <std::size_t n>
bool in_range(const std::array<double, n>& values) {
    return std::all_of(values.begin(), values.end(), [](double v) {
        const double magnitude = std::abs(v);
        return magnitude == 0 || (magnitude >= 0x1p-140 && magnitude <= 0x1p190);
    });
}

}  // namespace

int orient2d(Vec2 a, Vec2 b, Vec2 c) {
    const std::array values{a.x, a.y, b.x, b.y, c.x, c.y};
    if (in_range(values)) {
        return minus(product(difference(a.x, c.x), difference(b.y, c.y)),
                     product(difference(a.y, c.y), difference(b.x, c.x)))
            .sign();
    }
    const Scale s(values);
    const Integer left = (s(a.x) - s(c.x)) * (s(b.y) - s(c.y)), right = (s(a.y) - s(c.y)) * (s(b.x) - s(c.x));
    return left.compare(right);
}

int orient3d(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    const std::array values{a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, d.x, d.y, d.z};
    if (in_range(values)) {
        const Row p = row(b, a), q = row(c, a), r = row(d, a);
        return determinant(p, q, r, minor_xy(p, q), minor_xy(q, r), minor_xy(p, r)).sign();
    }
    const Scale s(values);
    return determinant(row(s, b, a), row(s, c, a), row(s, d, a)).sign();
}

int in_sphere(Vec3 a, Vec3 b, Vec3 c, Vec3 d, Vec3 e) {
    const std::array values{a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, d.x, d.y, d.z, e.x, e.y, e.z};
    if (in_range(values)) {
        const Row p = row(a, e), q = row(b, e), r = row(c, e), t = row(d, e);
        const auto pq = minor_xy(p, q), qr = minor_xy(q, r), rt = minor_xy(r, t), pr = minor_xy(p, r),
                   qt = minor_xy(q, t), pt = minor_xy(p, t);
        const auto qrt = determinant(q, r, t, qr, rt, qt), prt = determinant(p, r, t, pr, rt, pt),
                   pqt = determinant(p, q, t, pq, qt, pt), pqr = determinant(p, q, r, pq, qr, pr);
        const auto first = minus(product(qrt, squared_length(p)), product(prt, squared_length(q)));
        const auto last = minus(product(pqt, squared_length(r)), product(pqr, squared_length(t)));
        return sum(first, last).sign();
    }
    const Scale s(values);
    const IntegerRow p = row(s, a, e), q = row(s, b, e), r = row(s, c, e), t = row(s, d, e);
    const Integer value = squared_length(p) * determinant(q, r, t) -
                          squared_length(q) * determinant(p, r, t) +
                          squared_length(r) * determinant(p, q, t) - squared_length(t) * determinant(p, q, r);
    return value.sign();
}

}  // namespace anatomesh::exact
