#include "anatomesh/live/edit/drawn_contours.h"

#include <map>
#include <utility>

namespace anatomesh {

namespace {

// The planes with rings, by id, as slices without contours. Each has a name that no other one has.
std::map<std::int32_t, Slice> slices_by_plane(const Drawing& drawing) {
    std::map<std::string, int> uses;
    std::map<std::int32_t, Slice> slices;
    for (const auto& entry : drawing.rings().entries()) {
        const DrawnPlane& plane = *drawing.plane(entry.key.plane);
        if (slices
                .emplace(entry.key.plane, Slice{plane.plane, 0, 0, label_of_plane(drawing, entry.key.plane)})
                .second)
            ++uses[label_of_plane(drawing, entry.key.plane)];
    }
    for (auto& [id, slice] : slices) {
        if (uses[slice.name] == 1) continue;
        std::string name = slice.name + " (plane " + std::to_string(id) + ")";
        while (uses.contains(name)) name += "'";
        uses[name] = 1;
        slice.name = std::move(name);
    }
    return slices;
}

void append_rings(ContourSet& set, const DrawnRings& rings, std::uint32_t structure) {
    for (const DrawnRing& ring : rings.rings) {
        const auto points = rings.points_of(ring);
        set.contours.push_back({structure, static_cast<std::uint32_t>(set.slices.size() - 1),
                                static_cast<std::uint32_t>(set.points.size()), ring.point_count});
        set.points.insert(set.points.end(), points.begin(), points.end());
        ++set.slices.back().contour_count;
    }
}

}  // namespace

ContourSet drawn_contours(const Drawing& drawing) {
    std::map<std::int32_t, std::uint32_t> place_of;  // of a structure with rings, by its number
    for (const auto& entry : drawing.rings().entries()) place_of.emplace(entry.key.structure, 0);
    ContourSet set;
    for (auto& [number, place] : place_of) {
        place = static_cast<std::uint32_t>(set.structures.size());
        set.structures.push_back(drawing.structure(number)->structure);
    }
    auto slices = slices_by_plane(drawing);
    const auto entries = drawing.rings().entries();
    for (std::size_t i = 0; i < entries.size(); ++i) {
        const RingsKey key = entries[i].key;
        if (i == 0 || entries[i - 1].key.plane != key.plane) {
            set.slices.push_back(std::move(slices[key.plane]));
            set.slices.back().first_contour = static_cast<std::uint32_t>(set.contours.size());
        }
        append_rings(set, *entries[i].value, place_of[key.structure]);
    }
    set.frame = drawing.source().frame;
    set.pixel_mm = drawing.source().pixel_mm;
    set.slice_thickness_mm = drawing.source().slice_thickness_mm;
    return set;
}

RawContours raw_contours(const Drawing& drawing) {
    ContourSet set = drawn_contours(drawing);
    RawContours raw;
    raw.structures = std::move(set.structures);
    raw.points = std::move(set.points);
    raw.frame = set.frame;
    raw.pixel_mm = set.pixel_mm;
    raw.slice_thickness_mm = set.slice_thickness_mm;
    for (std::size_t s = 0; s < set.slices.size(); ++s) {
        const Slice& slice = set.slices[s];
        Plane plane = make_plane(slice.plane.origin, slice.plane.normal);
        plane.normal = slice.plane.normal;  // it has length 1, so a reader keeps it to the last bit
        raw.planes.push_back(plane);
        raw.plane_names.push_back(slice.name);
        for (std::uint32_t c = 0; c < slice.contour_count; ++c) {
            const Contour& contour = set.contours[slice.first_contour + c];
            raw.contours.push_back(
                {.structure = contour.structure,
                 .first_point = contour.first_point,
                 .point_count = contour.point_count,
                 .plane = static_cast<std::int32_t>(s),
                 .name = "slices[" + std::to_string(s) + "].contours[" + std::to_string(c) + "]"});
        }
    }
    return raw;
}

std::vector<std::string> slices_left_out(const Drawing& drawing) {
    std::vector<std::string> names;
    for (const auto& [id, slice] : slices_by_plane(drawing)) {
        if (drawing.plane(id)->left_out) names.push_back(slice.name);
    }
    return names;
}

}  // namespace anatomesh
