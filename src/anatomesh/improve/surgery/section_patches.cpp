#include "anatomesh/improve/surgery/section_patches.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <utility>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/improve/core/cell_snapshot.h"
#include "anatomesh/improve/core/surface_incidence.h"

namespace anatomesh {

namespace {

constexpr std::size_t most_sections = 200;  // of cells, in one cross-section [sections; > 0; B]

using Section = SectionAreas::Section;
using Ends = std::array<std::uint32_t, 2>;  // of an edge, rising; twice the same: a vertex

// Of a section: vertices in the plane, and edges that pass through it.
std::vector<Ends> corners_of(const EditMesh& mesh, const SectionAreas& areas, const Section& section,
                             std::uint32_t plane) {
    const Cell& cell = mesh.cell(section.cell);
    std::vector<Ends> corners;
    for (int i = 0; i < 4; ++i) {
        if (section.facet != i && areas.side(cell[i], plane) == 0) corners.push_back({cell[i], cell[i]});
    }
    if (section.facet < 4) return corners;
    for (const auto& [i, j] : cell_edges) {
        if (areas.side(cell[i], plane) * areas.side(cell[j], plane) < 0)
            corners.push_back({std::min(cell[i], cell[j]), std::max(cell[i], cell[j])});
    }
    return corners;
}

class PatchFinder {
  public:
    PatchFinder(EditContext& edit, const SectionAreas& areas) : edit_(edit), areas_(areas) {}

    std::vector<SectionPatch> run(std::vector<Section> left, std::uint32_t structure, std::uint32_t plane) {
        std::vector<SectionPatch> patches;
        while (!left.empty()) {
            SectionPatch patch{structure, plane, region_of(left.front(), structure), 0, {left.front()}};
            const std::optional<Region> to = region_drawn_at(left.front().middle);
            left.erase(left.begin());
            for (std::size_t n = 0; n < patch.sections.size(); ++n) {
                for (auto next = left.begin(); next != left.end();) {
                    if (region_of(*next, structure) != patch.own || region_drawn_at(next->middle) != to ||
                        !share_an_edge(patch.sections[n], *next, plane)) {
                        ++next;
                        continue;
                    }
                    patch.sections.push_back(*next);
                    next = left.erase(next);
                }
            }
            if (!to || edit_.table->contains(*to, structure) == edit_.table->contains(patch.own, structure))
                continue;
            patch.to = *to;
            for (const Section& section : patch.sections) patch.wrong += section.share;
            patches.push_back(std::move(patch));
        }
        std::stable_sort(patches.begin(), patches.end(),
                         [](const SectionPatch& a, const SectionPatch& b) { return a.wrong > b.wrong; });
        return patches;
    }

  private:
    // That of all that is drawn there, if the mesh has one.
    std::optional<Region> region_drawn_at(Vec3 p) {
        const std::vector<std::uint32_t>& drawn = edit_.probe.members(p);
        const auto& members = edit_.table->members;
        const auto found = std::find(members.begin(), members.end(), drawn);
        if (found == members.end()) return std::nullopt;
        return static_cast<Region>(found - members.begin());
    }

    // The one that must not be there: of a facet that has the structure on one side, that side's.
    Region region_of(const Section& section, std::uint32_t structure) const {
        const Region here = edit_.mesh.region(section.cell);
        if (section.facet == 4) return here;
        const Region there = edit_.mesh.region(edit_.mesh.neighbor(section.cell, section.facet));
        return edit_.table->contains(there, structure) ? there : here;
    }

    bool share_an_edge(const Section& one, const Section& other, std::uint32_t plane) const {
        const std::vector<Ends> corners = corners_of(edit_.mesh, areas_, one, plane);
        const std::vector<Ends> more = corners_of(edit_.mesh, areas_, other, plane);
        return std::count_if(corners.begin(), corners.end(), [&](const Ends& corner) {
                   return std::find(more.begin(), more.end(), corner) != more.end();
               }) >= 2;
    }

    EditContext& edit_;
    const SectionAreas& areas_;
};

class MembraneCutter {
  public:
    MembraneCutter(EditContext& edit, const SectionAreas& areas, std::uint32_t plane)
        : edit_(edit), areas_(areas), incidence_(edit), plane_(plane) {}

    Membrane run(const SectionPatch& patch, double near) {
        std::vector<CellSnapshot> passed;
        std::vector<std::uint32_t> corners;
        std::vector<Ends> edges;
        Membrane membrane;
        for (const Section& section : patch.sections) {
            const Cell cell = edit_.mesh.cell(section.cell);
            if (section.facet < 4) {
                const auto& f = facet_vertices[section.facet];
                membrane.facets.push_back({cell[f[0]], cell[f[1]], cell[f[2]]});
                std::sort(membrane.facets.back().begin(), membrane.facets.back().end());
                continue;
            }
            passed.push_back(CellSnapshot::of(edit_.mesh, section.cell));
            for (const Ends& corner : corners_of(edit_.mesh, areas_, section, plane_))
                (corner[0] == corner[1]) ? corners.push_back(corner[0]) : edges.push_back(corner);
        }
        sort_distinct(edges);
        add_near(corners, edges, near);
        sort_distinct(corners);
        std::erase_if(edges, [&](const Ends& edge) {
            return std::any_of(edge.begin(), edge.end(), [&](std::uint32_t v) {
                return std::binary_search(corners.begin(), corners.end(), v);
            });
        });
        for (const auto& [a, b] : edges) {
            const Vec3 p = edit_.mesh.point(a), q = edit_.mesh.point(b);
            const double at_p = height_of(p), at_q = height_of(q);
            if (!incidence_.find_ring(a, b)) return {};
            const std::uint32_t v = edit_.split_ring(p + at_p / (at_p - at_q) * (q - p));
            if (v == no_cell) return {};
            corners.push_back(v);
        }
        add_facets(membrane, corners, passed);
        return membrane;
    }

  private:
    // The ends of edges that the plane is nearest to.
    void add_near(std::vector<std::uint32_t>& corners, const std::vector<Ends>& edges, double near) const {
        for (const auto& [a, b] : edges) {
            const double at_a = height_of(edit_.mesh.point(a)), at_b = height_of(edit_.mesh.point(b));
            const double share = at_a / (at_a - at_b);
            if (share < near) corners.push_back(a);
            if (1 - share < near) corners.push_back(b);
        }
    }

    // Those between corners, with cells over and under them, in cells that the plane passed through.
    void add_facets(Membrane& membrane, std::vector<std::uint32_t> corners,
                    const std::vector<CellSnapshot>& passed) {
        std::vector<std::uint32_t> cells;
        for (const std::uint32_t v : corners) {
            edit_.mesh.star(v, edit_.star);
            cells.insert(cells.end(), edit_.star.begin(), edit_.star.end());
        }
        sort_distinct(cells);
        sort_distinct(corners);
        const auto is_corner = [&](std::uint32_t v) {
            return std::binary_search(corners.begin(), corners.end(), v);
        };
        for (const std::uint32_t c : cells) {
            const Cell& cell = edit_.mesh.cell(c);
            if (!find_snapshot(passed, edit_.mesh, c)) continue;
            for (int i = 0; i < 4; ++i) {
                const auto& f = facet_vertices[i];
                std::array facet{cell[f[0]], cell[f[1]], cell[f[2]]};
                if (!std::all_of(facet.begin(), facet.end(), is_corner)) continue;
                const std::uint32_t other = edit_.mesh.neighbor(c, i);
                if (other == no_cell || over(cell[i]) == over(apex_across(other, facet))) continue;
                std::sort(facet.begin(), facet.end());
                membrane.facets.push_back(facet);
            }
        }
        std::sort(membrane.facets.begin(), membrane.facets.end());
        membrane.facets.erase(std::unique(membrane.facets.begin(), membrane.facets.end()),
                              membrane.facets.end());
    }

    double height_of(Vec3 p) const { return areas_.plane(plane_).signed_distance(p); }
    bool over(std::uint32_t v) const { return height_of(edit_.mesh.point(v)) > 0; }

    std::uint32_t apex_across(std::uint32_t c, const std::array<std::uint32_t, 3>& facet) const {
        const Cell& cell = edit_.mesh.cell(c);
        return *std::find_if(cell.begin(), cell.end(), [&](std::uint32_t v) {
            return std::find(facet.begin(), facet.end(), v) == facet.end();
        });
    }

    EditContext& edit_;
    const SectionAreas& areas_;
    SurfaceIncidence incidence_;
    std::uint32_t plane_;
};

}  // namespace

std::vector<SectionPatch> find_patches(EditContext& edit, const SectionAreas& areas, std::uint32_t structure,
                                       std::uint32_t plane, int threads) {
    std::vector<Section> wrong = areas.wrong_sections_of(structure, plane, edit.mesh.alive_cells(), threads);
    if (wrong.size() > most_sections) return {};
    return PatchFinder(edit, areas).run(std::move(wrong), structure, plane);
}

Membrane membrane_of_patch(EditContext& edit, const SectionAreas& areas, const SectionPatch& patch,
                           double near) {
    return MembraneCutter(edit, areas, patch.plane).run(patch, near);
}

}  // namespace anatomesh
