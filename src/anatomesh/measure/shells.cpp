#include "anatomesh/measure/shells.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "anatomesh/base/disjoint_sets.h"
#include "anatomesh/mesh/model/buckets.h"

namespace anatomesh {

namespace {

// It stands for no shell. [index; 2^32 - 1; D]
constexpr std::uint32_t no_shell = 0xFFFFFFFFu;

std::size_t count_of(std::span<const std::uint32_t> shell_of) {
    return shell_of.empty() ? 0 : std::size_t{*std::max_element(shell_of.begin(), shell_of.end())} + 1;
}

// Signed: negative for voids. By cones from each shell's own first vertex.
std::vector<double> volumes_of(std::span<const Vec3> points, std::span<const Triangle> surface,
                               std::span<const std::uint32_t> shell_of) {
    assert(surface.size() == shell_of.size());
    std::vector<double> volumes(count_of(shell_of), 0);
    std::vector<std::uint32_t> apex(volumes.size(), no_cell);
    for (std::size_t t = 0; t < surface.size(); ++t) {
        const Triangle& f = surface[t];
        std::uint32_t& from = apex[shell_of[t]];
        if (from == no_cell) from = f[0];
        const Vec3 a = points[f[0]] - points[from], b = points[f[1]] - points[from],
                   c = points[f[2]] - points[from];
        volumes[shell_of[t]] += dot(a, cross(b, c)) / 6;
    }
    return volumes;
}

// Counts the contours of the structure whose vertices lie on several shells, and joins those shells.
void join_by_contours(const ContourSet& contours, std::span<const std::size_t> match, std::size_t structure,
                      std::span<const std::uint32_t> vertex_of, const std::vector<std::uint32_t>& shell_at,
                      std::size_t shells, ShellReport& report) {
    DisjointSets joined(shells);
    std::size_t most = 1;
    for (const Contour& contour : contours.contours) {
        if (match[contour.structure] != structure) continue;
        std::vector<std::uint32_t> met;
        for (std::uint32_t n = contour.first_point; n < contour.first_point + contour.point_count; ++n) {
            const std::uint32_t v = vertex_of[n];
            const std::uint32_t shell = v == no_cell ? no_shell : shell_at[v];
            if (shell != no_shell && (met.empty() || met.back() != shell)) met.push_back(shell);
        }
        std::sort(met.begin(), met.end());
        met.erase(std::unique(met.begin(), met.end()), met.end());
        if (met.size() < 2) continue;
        ++report.contours_in_parts;
        if (met.size() > most) {
            most = met.size();
            const Slice& slice = contours.slices[contour.slice];
            report.worst_slice = slice.name.empty() ? std::to_string(contour.slice) : slice.name;
        }
        for (const std::uint32_t shell : met) {
            if (joined.root(shell) == joined.root(met.front())) continue;
            joined.join(shell, met.front());
            ++report.parts_too_many;
        }
    }
}

}  // namespace

ShellReport count_shells(std::span<const Vec3> points, std::span<const Triangle> surface,
                         std::span<const std::uint32_t> shell_of) {
    ShellReport report;
    const std::vector<double> volumes = volumes_of(points, surface, shell_of);
    for (std::size_t s = 0; s < volumes.size(); ++s) {
        report.voids += volumes[s] < 0;
        const double volume = std::abs(volumes[s]);
        report.smallest_mm3 = s == 0 ? volume : std::min(report.smallest_mm3, volume);
    }
    return report;
}

void look_for_contours(std::span<const Vec3> points, std::span<const Triangle> surface,
                       std::span<const std::uint32_t> shell_of, const ContourSet& contours,
                       std::span<const std::size_t> match, std::size_t structure,
                       std::span<const std::uint32_t> vertex_of, ShellReport& report) {
    const std::vector<double> volumes = volumes_of(points, surface, shell_of);
    if (volumes.empty()) return;
    std::vector<std::uint8_t> of_contour(points.size(), 0), known(volumes.size(), 0);
    for (const std::uint32_t v : vertex_of) {
        if (v != no_cell) of_contour[v] = 1;
    }
    std::vector<std::uint32_t> shell_at(points.size(), no_shell);
    for (std::size_t t = 0; t < surface.size(); ++t) {
        for (const std::uint32_t v : surface[t]) {
            shell_at[v] = shell_of[t];
            if (of_contour[v]) known[shell_of[t]] = 1;
        }
    }
    std::uint32_t largest = no_shell;
    for (std::uint32_t s = 0; s < volumes.size(); ++s) {
        if (known[s]) continue;
        ++report.without_contour;
        report.without_contour_mm3 += std::abs(volumes[s]);
        if (largest == no_shell || std::abs(volumes[s]) > std::abs(volumes[largest])) largest = s;
    }
    if (largest != no_shell) {
        report.largest_without_contour_mm3 = std::abs(volumes[largest]);
        Vec3 sum;
        double triangles = 0;
        for (std::size_t t = 0; t < surface.size(); ++t) {
            if (shell_of[t] != largest) continue;
            for (const std::uint32_t v : surface[t]) sum += points[v];
            triangles += 1;
        }
        report.largest_at = {sum.x / (3 * triangles), sum.y / (3 * triangles), sum.z / (3 * triangles)};
    }
    join_by_contours(contours, match, structure, vertex_of, shell_at, volumes.size(), report);
}

}  // namespace anatomesh
