#include "anatomesh/refine/section_points.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "anatomesh/base/parallel.h"
#include "anatomesh/sample/interface_probe.h"

namespace anatomesh {

namespace {

struct WrongSection {
    std::uint32_t cell;
    std::size_t cross_section;  // structure * slices + slice
    double share;               // of what is drawn
    double area;                // mm^2
    Vec3 place;                 // of a vertex for it
};

// A point lies so far from the middle of a section towards the middle of the cell: in the plane itself a vertex would
// make flat cells with those of contours. [roots of the section's area; 0 to 0.5; M 2026-11 69 sets about an axis]
constexpr double beside_share = 0.05;

Vec3 beside_plane(const Plane& plane, const PlaneSection& section, const std::vector<Vec3>& points,
                  const Cell& cell) {
    const Vec3 centre = 0.25 * (points[cell[0]] + points[cell[1]] + points[cell[2]] + points[cell[3]]);
    const double beside = beside_share * std::sqrt(section.area);
    return section.middle + (plane.signed_distance(centre) > 0 ? beside : -beside) * plane.normal;
}

double squared_distance(Vec3 p, const ContradictedPlace& place) {
    const Vec3 way = place.to - place.from;
    const double share = std::clamp(dot(p - place.from, way) / squared_length(way), 0.0, 1.0);
    return squared_length(p - (place.from + share * way));
}

bool is_contradicted(const CrossedSlices& slices, std::uint32_t structure, Vec3 p, double clearance) {
    return std::any_of(
        slices.contradicted.begin(), slices.contradicted.end(), [&](const ContradictedPlace& place) {
            return place.structure == structure && squared_distance(p, place) < clearance * clearance;
        });
}

// In the order of `look`, and of planes and structures.
std::vector<WrongSection> wrong_sections(const LabelledMeshView& mesh, const CrossedSlices& slices,
                                         const SectionPointOptions& options,
                                         const std::vector<std::uint32_t>& look, int threads) {
    const std::vector<Vec3>& points = mesh.points;
    // So many cells are looked at in one task. [cells at a time; >= 1; B]
    constexpr std::size_t grain = 4096;
    return parallel_collect<WrongSection>(
        look.size(), grain, threads,
        [&](std::size_t first, std::size_t last, std::vector<WrongSection>& found) {
            InterfaceProbe probe(mesh.field, mesh.structures);
            const auto add_wrong = [&](std::uint32_t c, std::uint32_t k, const PlaneSection& section) {
                const std::vector<std::uint32_t>* drawn = nullptr;
                for (std::uint32_t s = 0; s < mesh.structures; ++s) {
                    const std::size_t cross_section = s * slices.planes.planes.size() + k;
                    const double share = section.area * slices.weights[cross_section];
                    if (!(share > options.least_of_section)) continue;
                    if (!drawn) drawn = &probe.members(section.middle);
                    if (std::binary_search(drawn->begin(), drawn->end(), s) !=
                            mesh.table.contains(mesh.regions[c], s) &&
                        !is_contradicted(slices, s, section.middle, options.clearance_mm))
                        found.push_back(
                            {c, cross_section, share, section.area,
                             beside_plane(slices.planes.planes[k], section, points, mesh.cells[c])});
                }
            };
            for (std::size_t n = first; n < last; ++n) {
                const Cell& cell = mesh.cells[look[n]];
                for_each_section({points[cell[0]], points[cell[1]], points[cell[2]], points[cell[3]]},
                                 slices.planes, [&](std::uint32_t k, const PlaneSection& section) {
                                     if (section.facet == PlaneSection::no_facet)
                                         add_wrong(look[n], k, section);
                                 });
            }
        });
}

// Drops sections in cross-sections that stay as they are.
void drop_small_cross_sections(std::vector<WrongSection>& sections, std::size_t cross_sections,
                               double least_of_cross_section) {
    std::vector<double> sums(cross_sections, 0);
    for (const WrongSection& section : sections) sums[section.cross_section] += section.share;
    std::erase_if(sections, [&](const WrongSection& section) {
        return sums[section.cross_section] < least_of_cross_section;
    });
}

}  // namespace

SectionPointStats find_section_points(const LabelledMeshView& mesh, const CrossedSlices& slices,
                                      const OccupiedSpace& occupied, const SectionPointOptions& options,
                                      std::vector<std::uint32_t>& look, std::vector<Vec3>& found,
                                      RunContext& context) {
    assert(slices.weights.size() == mesh.structures * slices.planes.planes.size());
    std::vector<WrongSection> sections = wrong_sections(mesh, slices, options, look, context.threads);
    drop_small_cross_sections(sections, slices.weights.size(), options.least_of_cross_section);
    SectionPointStats stats;
    stats.wrong = sections.size();
    look.clear();
    double total = 0;
    for (const WrongSection& section : sections) {
        if (look.empty() || look.back() != section.cell) look.push_back(section.cell);
        total += std::sqrt(section.area);
    }
    std::stable_sort(sections.begin(), sections.end(),
                     [](const WrongSection& a, const WrongSection& b) { return a.area > b.area; });
    PointGrid chosen(sections.empty() ? 1.0 : total / static_cast<double>(sections.size()), sections.size());
    for (const WrongSection& section : sections) {
        const double spacing = options.min_spacing * std::sqrt(section.area);
        if (occupied.vertices.any_within(section.place, spacing) ||
            !occupied.protected_segments.outside_balls(section.place)) {
            ++stats.refused;
            continue;
        }
        if (chosen.any_within(section.place, 2 * spacing)) continue;
        chosen.add(section.place);
        found.push_back(section.place);
    }
    return stats;
}

}  // namespace anatomesh
