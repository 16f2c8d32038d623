#include "anatomesh/sample/thin_walls.h"

#include <algorithm>
#include <cmath>

#include "anatomesh/geom/box.h"

namespace anatomesh {

namespace {

// Finer points go so far about a thin spot: as far as its neighbours among the ordinary points.
// [sizes; > 0; M 2026-11 skull]
constexpr double spot_reach = 0.7;
// Thickness over edge length that keeps a wall whole. [1; 0 to 1; M 2026-11 shells of lattice points]
constexpr double edge_share = 0.6;
// So far beyond a surface it is seen what is there. [sizes; 0 to 0.1; M 2026-11 skull]
constexpr double just_off = 0.02;

}  // namespace

int level_of(double thickness, double size) {
    if (!(thickness < thin_wall * size)) return 0;
    return std::clamp(static_cast<int>(std::ceil(std::log2(edge_share * size / thickness))), 1,
                      max_thin_level);
}

std::optional<double> thickness_beside(Vec3 p, Vec3 surface, const LocalThickness& local_thickness,
                                       InterfaceProbe& probe, std::uint32_t structures,
                                       std::vector<std::uint32_t>& changed) {
    const double moved = length(surface - p), off = just_off * local_thickness.reach();
    if (!(moved > 0.1 * off)) return std::nullopt;
    const Vec3 away = (1.0 / moved) * (surface - p);
    const std::vector<std::uint32_t> before = probe.members(p);
    if (structures == 1) return local_thickness.thickness(0, surface, before.empty() ? -1.0 * away : away);
    const std::vector<std::uint32_t>& after = probe.members(surface + off * away);
    changed.clear();
    std::set_symmetric_difference(before.begin(), before.end(), after.begin(), after.end(),
                                  std::back_inserter(changed));
    double least = local_thickness.reach();
    for (const std::uint32_t structure : changed) {
        const bool leaving = std::binary_search(before.begin(), before.end(), structure);
        least = std::min(least, local_thickness.thickness(structure, surface, leaving ? away : -1.0 * away));
    }
    return least;
}

std::vector<Vec3> fine_sites(Vec3 low, const std::vector<ThinSpot>& spots, int level, double size) {
    const double step = 0.5 * size / (1 << level), reach = spot_reach * size, r = reach / step;
    // Sites by one number that rises with k, then j, then i.
    Box3 box;
    for (const ThinSpot& spot : spots) box.extend((1.0 / step) * (spot.point - low));
    if (box.empty()) return {};
    const auto first = [&](double at) { return static_cast<std::int64_t>(std::floor(at - r)); };
    const std::int64_t i0 = first(box.low.x), j0 = first(box.low.y), k0 = first(box.low.z);
    const auto count = [&](double high, std::int64_t from) {
        return static_cast<std::int64_t>(std::floor(high + r)) + 1 - from;
    };
    const std::int64_t nx = count(box.high.x, i0), ny = count(box.high.y, j0);
    // A stretch of a row by its first and its last site; every second number between them is a site, too.
    struct Stretch {
        std::int64_t first, last;
        bool operator<(const Stretch& other) const { return first < other.first; }
    };
    std::vector<Stretch> stretches;
    std::size_t look_for_overlaps = 4'000'000;
    const auto join_overlapping = [&] {
        std::sort(stretches.begin(), stretches.end());
        std::size_t joined = 0;
        for (const Stretch& stretch : stretches) {
            if (joined > 0 && stretch.first <= stretches[joined - 1].last) {
                stretches[joined - 1].last = std::max(stretches[joined - 1].last, stretch.last);
            } else {
                stretches[joined++] = stretch;
            }
        }
        stretches.resize(joined);
        look_for_overlaps = std::max(look_for_overlaps, 2 * joined);
    };
    for (const ThinSpot& spot : spots) {
        if (spot.level < level) continue;
        const Vec3 p = (1.0 / step) * (spot.point - low);
        for (auto k = static_cast<std::int64_t>(std::ceil(p.z - r)); k <= p.z + r; ++k) {
            const double in_layer = r * r - (static_cast<double>(k) - p.z) * (static_cast<double>(k) - p.z);
            for (auto j = static_cast<std::int64_t>(std::ceil(p.y - r)); j <= p.y + r; ++j) {
                const double in_row =
                    in_layer - (static_cast<double>(j) - p.y) * (static_cast<double>(j) - p.y);
                if (((j - k) & 1) || in_row < 0) continue;
                const double half = std::sqrt(in_row);
                auto from = static_cast<std::int64_t>(std::ceil(p.x - half)),
                     to = static_cast<std::int64_t>(std::floor(p.x + half));
                from += (from - k) & 1;
                to -= (to - k) & 1;
                const std::int64_t row = ((k - k0) * ny + (j - j0)) * nx - i0;
                if (from <= to) stretches.push_back({row + from, row + to});
            }
        }
        // Spots lie close together: join their stretches before they take much memory.
        if (stretches.size() > look_for_overlaps) join_overlapping();
    }
    join_overlapping();
    std::vector<Vec3> points;
    for (const Stretch& stretch : stretches) {
        for (std::int64_t site = stretch.first; site <= stretch.last; site += 2) {
            const std::int64_t i = site % nx + i0, j = site / nx % ny + j0, k = site / nx / ny + k0;
            points.push_back(
                low + step * Vec3{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
        }
    }
    return points;
}

}  // namespace anatomesh
