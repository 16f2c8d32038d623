#include "anatomesh/delaunay/spatial_order.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

#include "anatomesh/base/parallel.h"
#include "anatomesh/geom/box.h"

namespace anatomesh {

namespace {

// ---- The curve: at every level the octant in space gives a digit and the frame of the level below ----

struct Step {
    std::uint8_t digit, frame;
};
// A frame of the curve has one of eight corners to enter by and one of three directions. [frames; 24; D]
constexpr int frame_count = 24;

constexpr unsigned rotated_left(unsigned bits, unsigned by) {
    return ((bits << (by % 3)) | (bits >> (3 - by % 3))) & 7u;
}

// Hamilton's recurrences for three dimensions.
constexpr std::array<std::array<Step, 8>, frame_count> hilbert_steps() {
    std::array<std::array<Step, 8>, frame_count> steps{};
    for (unsigned entry = 0; entry < 8; ++entry) {
        for (unsigned direction = 0; direction < 3; ++direction) {
            for (unsigned octant = 0; octant < 8; ++octant) {
                const unsigned gray = rotated_left(octant ^ entry, 2 - direction);
                const unsigned digit = gray ^ (gray >> 1) ^ (gray >> 2);
                const unsigned even = digit == 0 ? 0 : 2 * ((digit - 1) / 2);
                const unsigned entry_below = even ^ (even >> 1);
                unsigned turn = 0;
                if (digit != 0)
                    turn = static_cast<unsigned>(std::countr_one(digit % 2 ? digit : digit - 1)) % 3;
                const unsigned next_entry = entry ^ rotated_left(entry_below, direction + 1);
                const unsigned next_direction = (direction + turn + 1) % 3;
                steps[3 * entry + direction][octant] = {
                    static_cast<std::uint8_t>(digit),
                    static_cast<std::uint8_t>(3 * next_entry + next_direction)};
            }
        }
    }
    return steps;
}
constexpr auto steps = hilbert_steps();

constexpr int key_levels =
    16;  // So many halvings of the box along each axis fit into 64 bits. [halvings; 1 to 21; D]
// A key has three bits for each level of the curve. [bits; 3 to 63; D]
constexpr int key_bits = 3 * key_levels;

// Places of points along the Hilbert curve that fills a box.
class HilbertCurve {
  public:
    explicit HilbertCurve(const Box3& box) : low_(box.low) {
        // Halves, so that the extent does not overflow; a cube, so that the curve is fair in all directions.
        const Vec3 half = 0.5 * box.high - 0.5 * box.low;
        const double largest = std::max({half.x, half.y, half.z});
        scale_ = largest > 0x1p-1000 ? 0.5 * cells / largest : 0;
        half_low_ = 0.5 * low_;
    }

    std::uint64_t key(Vec3 p) const {
        const std::uint32_t x = place(p.x, half_low_.x), y = place(p.y, half_low_.y),
                            z = place(p.z, half_low_.z);
        std::uint64_t key = 0;
        unsigned frame = 0;
        for (int level = key_levels - 1; level >= 0; --level) {
            const unsigned octant = ((x >> level) & 1u) | ((y >> level) & 1u) << 1 | ((z >> level) & 1u) << 2;
            const Step step = steps[frame][octant];
            key = key << 3 | step.digit;
            frame = step.frame;
        }
        return key;
    }

  private:
    // The curve parts each axis into so many cells. [cells; 2^key_levels; D]
    static constexpr double cells = 1 << key_levels;
    std::uint32_t place(double value, double half_low) const {
        const double at = 2 * ((0.5 * value - half_low) * scale_);
        return static_cast<std::uint32_t>(std::clamp(at, 0.0, cells - 1));
    }

    Vec3 low_, half_low_;
    double scale_;
};

// ---- Sorting ----

struct Keyed {
    std::uint64_t key;
    std::uint32_t point;
};

// By key, stable: eleven bits at a time, from the lowest.
void radix_sort(std::vector<Keyed>& items, int bits) {
    // The radix sort takes so many bits at a time: its counters stay in the cache. [bits; 1 to 16; B]
    constexpr int digit_bits = 11;
    std::vector<Keyed> other(items.size());
    for (int shift = 0; shift < bits; shift += digit_bits) {
        std::array<std::uint32_t, (1 << digit_bits) + 1> begins{};
        const auto digit = [&](const Keyed& item) { return (item.key >> shift) & ((1u << digit_bits) - 1); };
        for (const Keyed& item : items) ++begins[digit(item) + 1];
        std::partial_sum(begins.begin(), begins.end(), begins.begin());
        for (const Keyed& item : items) other[begins[digit(item)]++] = item;
        items.swap(other);
    }
}

void sort_by_coordinates(std::span<const Vec3> points, std::span<Keyed> items) {
    std::sort(items.begin(), items.end(), [&](const Keyed& a, const Keyed& b) {
        const Vec3 p = points[a.point], q = points[b.point];
        return p == q ? a.point < b.point : lexicographic_less(p, q);
    });
}

// Runs of equal keys: short ones are sorted by coordinates, long ones are pushed, to get a curve of their
// own.
void settle_runs(std::span<const Vec3> points, std::span<Keyed> items,
                 std::vector<std::span<Keyed>>& long_runs) {
    // So many points in one cell of the curve get a curve of their own; fewer are sorted by coordinates.
    // [points; >= 1; B]
    constexpr std::size_t least = 16;
    for (std::size_t begin = 0, end = 0; begin < items.size(); begin = end) {
        while (end < items.size() && items[end].key == items[begin].key) ++end;
        const std::span<Keyed> run = items.subspan(begin, end - begin);
        if (run.size() >= least) {
            long_runs.push_back(run);
        } else if (run.size() > 1) {
            sort_by_coordinates(points, run);
        }
    }
}

// Orders the points of a run by a curve through their own box.
void refine_run(std::span<const Vec3> points, std::span<Keyed> run,
                std::vector<std::span<Keyed>>& long_runs) {
    Box3 box;
    for (const Keyed& item : run) box.extend(points[item.point]);
    const HilbertCurve curve(box);
    for (Keyed& item : run) item.key = curve.key(points[item.point]);
    std::sort(run.begin(), run.end(), [](const Keyed& a, const Keyed& b) { return a.key < b.key; });
    if (run.front().key == run.back().key) {
        sort_by_coordinates(points, run);  // equal points, or a box too small for a curve
    } else {
        settle_runs(points, run, long_runs);
    }
}

// ---- Rounds ----

std::uint64_t mixed(std::uint64_t bits) {
    bits = (bits ^ (bits >> 30)) * 0xBF58476D1CE4E5B9u;
    bits = (bits ^ (bits >> 27)) * 0x94D049BB133111EBu;
    return bits ^ (bits >> 31);
}

// How many rounds from the last a point goes in: 0 for seven of eight, 1 for seven of eight of the rest, ...
// It depends on the digits of the coordinates, not on their exponents: other units of length that are a power
// of two times as long change nothing.
unsigned round_from_last(Vec3 p, std::uint64_t key, unsigned most) {
    // The mask leaves the digits of a double without sign and exponent.
    // [bits of a double; 2^52 - 1; D IEEE 754]
    constexpr std::uint64_t digits = (std::uint64_t{1} << 52) - 1;
    std::uint64_t bits = mixed(key + 0x9E3779B97F4A7C15u);
    for (const double value : {p.x, p.y, p.z})
        bits = mixed(bits + (std::bit_cast<std::uint64_t>(value) & digits));
    return std::min(static_cast<unsigned>(std::countr_zero(bits | std::uint64_t{1} << 63)) / 3, most);
}

}  // namespace

SpatialOrder spatial_order(std::span<const Vec3> points, std::size_t known, int threads) {
    // A round of insertion has at least so many points: smaller ones cost more than they even out.
    // [points; >= 1; B]
    constexpr std::size_t smallest_round = 64;
    unsigned rounds = 1;
    for (std::size_t size = points.size(); size / 8 > std::max(known, smallest_round); size /= 8) ++rounds;

    Box3 box;
    for (const Vec3& p : points) box.extend(p);
    const HilbertCurve curve(box);
    std::vector<Keyed> items(points.size());
    parallel_for(points.size(), 4096, threads, [&](std::size_t first, std::size_t last) {
        for (std::size_t n = first; n < last; ++n) {
            const std::uint64_t key = curve.key(points[n]);
            const std::uint64_t round = rounds - 1 - round_from_last(points[n], key, rounds - 1);
            items[n] = {round << key_bits | key, static_cast<std::uint32_t>(n)};
        }
    });
    radix_sort(items, key_bits + std::bit_width(rounds - 1));

    SpatialOrder result;
    for (std::uint64_t round = 0; round < rounds; ++round) {
        const auto begin = std::partition_point(
            items.begin(), items.end(), [&](const Keyed& item) { return item.key >> key_bits < round; });
        result.round_begins.push_back(static_cast<std::uint32_t>(begin - items.begin()));
    }
    result.round_begins.push_back(static_cast<std::uint32_t>(items.size()));

    std::vector<std::span<Keyed>> runs;
    settle_runs(points, items, runs);
    while (!runs.empty()) {
        const std::span<Keyed> run = runs.back();
        runs.pop_back();
        refine_run(points, run, runs);
    }
    result.order.resize(items.size());
    std::transform(items.begin(), items.end(), result.order.begin(),
                   [](const Keyed& item) { return item.point; });
    return result;
}

}  // namespace anatomesh
