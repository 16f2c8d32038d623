// Where a model's surface is joined otherwise than its contours show, told to the user, whoever made it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/measure/report.h"
#include "anatomesh/measure/topology/spurious_joints.h"
#include "anatomesh/measure/topology/topology_check.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

struct TopologyInput {
    const TetMesh& mesh;
    std::span<const std::uint32_t> neighbors;  // as cell_neighbors() gives them
    const RegionTable& regions;
    std::span<const StructureReport> structures;  // measured, of the model
    const ContourSet& contours;
    std::span<const std::size_t> structure_of;  // the model's, of each of the contours; beyond: none
    std::span<const std::uint32_t> vertex_of;   // of every contour point, or no_cell
    double size_mm = 0;                         // edge length
};

struct TopologyFindings {
    std::vector<TopologyMismatch> of_slices;
    std::vector<SpuriousJoint> between_planes;  // where planes cross
    std::vector<SpuriousJoint> small;           // there, handles of about an edge length
};

// The tears of topology_check() that are sure to be none of the field's own: of structures twice as thick in
// the mean as the edge length those alone that go on from end to end, and where parts branch or vanish no
// joints. Of planes that are no sweep also spurious_joints(), and those small_handles() within one and a half
// edge lengths that no whole contour is drawn beside. Requires: surfaces that are closed manifolds.
TopologyFindings check_topology(const TopologyInput& model, int threads);

// Where planes cross, how many of them; of what each of two ways sees what sees more, by structure.
std::size_t spurious_places(const TopologyFindings& tears);

// W-PIP-004, once for each structure. `tears`: as check_topology() gives them.
void warn_of_topology(const TopologyFindings& tears, const ContourSet& contours, double size_mm,
                      RunContext& context);

}  // namespace anatomesh
