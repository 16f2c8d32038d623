#include "anatomesh/pipeline/tear_warnings.h"

#include <algorithm>
#include <cstdlib>

#include "anatomesh/contour/message_text.h"
#include "anatomesh/mesh/topology.h"
#include "anatomesh/sample/sample_points.h"

namespace anatomesh {

namespace {

constexpr double tears_below = 2;  // a structure this many sizes thick in the mean has no walls that tear
constexpr double finer = 0.7;      // size to try

// By structure, whether a slice shows several contours of it: they follow one another.
std::vector<std::uint8_t> shown_in_several(const ContourSet& contours) {
    std::vector<std::uint8_t> several(contours.structures.size(), 0);
    for (std::size_t c = 1; c < contours.contours.size(); ++c) {
        const Contour &before = contours.contours[c - 1], &here = contours.contours[c];
        if (before.slice == here.slice && before.structure == here.structure) several[here.structure] = 1;
    }
    return several;
}

}  // namespace

std::vector<SurfaceTear> find_tears(const TornModel& model, int threads) {
    const ContourSet& contours = model.contours;
    std::vector<std::vector<Triangle>> surfaces(contours.structures.size());
    // Where walls do not tear only what goes on from end to end is sure to be amiss.
    std::vector<std::uint8_t> thick;
    for (const double t : mean_thickness(contours)) thick.push_back(t >= tears_below * model.size_mm);
    const std::vector<std::uint8_t> several = shown_in_several(contours);
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
        if (model.structure_of[s] >= model.structures.size()) continue;
        // Without a handle no wall is torn, and where no slice shows two contours no gap is filled.
        const StructureReport& structure = model.structures[model.structure_of[s]];
        const bool one_shell = structure.genus <= 0 && structure.components <= 1;
        if (one_shell && !several[s]) continue;
        surfaces[s] = structure_surface(model.mesh, model.neighbors, model.regions,
                                        static_cast<std::uint32_t>(model.structure_of[s]), threads);
    }
    std::vector<SurfaceTear> tears =
        surface_tears(model.mesh.points, surfaces, contours, model.vertex_of, thick, threads);
    // Where parts branch or vanish the field itself may join them, near the ends of the run.
    std::erase_if(tears, [](const SurfaceTear& t) { return !t.whole && t.euler > t.expected; });
    return tears;
}

void warn_of_tears(std::span<const SurfaceTear> tears, const ContourSet& contours, double size_mm,
                   RunContext& context) {
    for (auto tear = tears.begin(); tear != tears.end();) {
        // All of one structure, the worst named.
        const auto amiss = [](const SurfaceTear& t) { return std::abs(t.euler - t.expected); };
        const auto worse = [&](const SurfaceTear& x, const SurfaceTear& y) { return amiss(x) < amiss(y); };
        const auto end = std::find_if(tear, tears.end(),
                                      [&](const SurfaceTear& t) { return t.structure != tear->structure; });
        std::int64_t count = 0;
        for (auto t = tear; t != end; ++t) count += (amiss(*t) + 1) / 2;
        const SurfaceTear& worst = *std::max_element(tear, end, worse);
        const Structure& structure = contours.structures[worst.structure];
        Place place;
        place.file = contours.source;
        place.structure = structure.name.empty() ? std::to_string(structure.number) : structure.name;
        place.slice = contours.slices[worst.low_slice].name;
        place.value = std::to_string(count) + (count == 1 ? " place" : " places");
        const std::string where = worst.low_slice == worst.high_slice
                                      ? "at the end beyond this slice"
                                      : "between this slice and " + contours.slices[worst.high_slice].name;
        context.warn(
            {"W-PIP-004",
             "the surface is joined otherwise than the contours show, by holes in a thin wall or "
             "bridges over a narrow gap; most " +
                 where,
             place,
             std::string(worst.by_mesh ? "kept; --size " : "kept; a plane through the place, or --size ") +
                 brief(finer * size_mm) + " may resolve it: look at the components and the genus"});
        tear = end;
    }
}

}  // namespace anatomesh
