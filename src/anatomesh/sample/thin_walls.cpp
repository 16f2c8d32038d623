#include "anatomesh/sample/thin_walls.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace anatomesh {

namespace {

constexpr double spot_reach = 0.7;       // about a thin spot, in sizes: as far as its neighbours among the ordinary points
constexpr double edge_share = 0.6;      // thickness / edge length that keeps a wall whole
constexpr double just_off = 0.02;        // beyond a surface, to see what is there; in sizes

}  // namespace

int level_of(double thickness, double size) {
    if (!(thickness < thin_wall * size)) return 0;
    return std::clamp(static_cast<int>(std::ceil(std::log2(edge_share * size / thickness))), 1, max_thin_level);
}

std::optional<double> thickness_beside(Vec3 p, Vec3 surface, const WallGauge& gauge, InterfaceProbe& probe,
                                       std::uint32_t structures, std::vector<std::uint32_t>& changed) {
    const double moved = length(surface - p), off = just_off * gauge.reach();
    if (!(moved > 0.1 * off)) return std::nullopt;
    const Vec3 away = (1.0 / moved) * (surface - p);
    const std::vector<std::uint32_t> before = probe.members(p);
    if (structures == 1) return gauge.thickness(0, surface, before.empty() ? -1.0 * away : away);
    const std::vector<std::uint32_t>& after = probe.members(surface + off * away);
    changed.clear();
    std::set_symmetric_difference(before.begin(), before.end(), after.begin(), after.end(), std::back_inserter(changed));
    double least = gauge.reach();
    for (const std::uint32_t structure : changed) {
        const bool leaving = std::binary_search(before.begin(), before.end(), structure);
        least = std::min(least, gauge.thickness(structure, surface, leaving ? away : -1.0 * away));
    }
    return least;
}

std::vector<Vec3> fine_sites(Vec3 low, const std::vector<ThinSpot>& spots, int level, double size) {
    const double step = 0.5 * size / (1 << level), reach = spot_reach * size;
    using Site = std::array<std::int64_t, 3>;
    std::vector<Site> sites;
    std::size_t look_for_repeats = 4'000'000;
    const auto drop_repeats = [&] {
        std::sort(sites.begin(), sites.end());
        sites.erase(std::unique(sites.begin(), sites.end()), sites.end());
        look_for_repeats = std::max(look_for_repeats, 2 * sites.size());
    };
    for (const ThinSpot& spot : spots) {
        if (spot.level < level) continue;
        const Vec3 p = (1.0 / step) * (spot.point - low);
        const double r = reach / step;
        for (auto k = static_cast<std::int64_t>(std::ceil(p.z - r)); k <= p.z + r; ++k) {
            for (auto j = static_cast<std::int64_t>(std::ceil(p.y - r)); j <= p.y + r; ++j) {
                if ((j - k) & 1) continue;
                for (auto i = static_cast<std::int64_t>(std::ceil(p.x - r)); i <= p.x + r; ++i) {
                    if ((i - k) & 1) continue;
                    const Vec3 site{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)};
                    if (squared_length(site - p) <= r * r) sites.push_back({k, j, i});
                }
            }
        }
        // Spots lie close together: drop the repeats before they take much memory.
        if (sites.size() > look_for_repeats) drop_repeats();
    }
    drop_repeats();
    std::vector<Vec3> points;
    points.reserve(sites.size());
    for (const Site& s : sites) {
        points.push_back(low + step * Vec3{static_cast<double>(s[2]), static_cast<double>(s[1]), static_cast<double>(s[0])});
    }
    return points;
}

}  // namespace anatomesh
