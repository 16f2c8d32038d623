#include "anatomesh/cut/resolve_nonmanifold.h"

#include <optional>
#include <string>

#include "anatomesh/base/number_text.h"
#include "anatomesh/cut/cut_spindles.h"
#include "anatomesh/cut/join_lost_vertices.h"
#include "anatomesh/cut/nonmanifold_patch.h"

namespace anatomesh {

namespace {

constexpr int most_relabellings = 20;  // So many passes relabel components. [passes; >= 0; B]

Error stays_nonmanifold(const NonmanifoldPatch& patch, const std::vector<std::uint32_t>& vertices) {
    const Vec3 at = patch.points[vertices.front()];
    return Error{
        ErrorKind::geometry,
        "E-CUT-001",
        std::to_string(vertices.size()) + " vertices of the surface could not be made manifold",
        {"", "", "", "", "first at " + brief(at.x) + ", " + brief(at.y) + ", " + brief(at.z) + " mm"},
        "give another --size"};
}

}  // namespace

Result<NonmanifoldStats> resolve_nonmanifold(TetMesh& mesh, const std::vector<std::uint32_t>& vertices,
                                             const ContourOwners& owners, RegionRegistry& registry,
                                             const NonmanifoldOptions& options) {
    NonmanifoldStats stats;
    if (vertices.empty()) return stats;
    NonmanifoldPatch patch = NonmanifoldPatch::take_from(mesh, vertices, owners, registry);
    std::optional<PatchStars> stars;
    int relabellings = 0;
    for (int pass = 0; pass < options.max_passes; ++pass) {
        stars.emplace(patch);
        if (stars->nonmanifold.empty()) {
            patch.put_back(mesh);
            return stats;
        }
        const std::uint64_t joined = join_lost_vertices(patch, *stars);
        stats.vertices_joined += joined;
        if (joined > 0) continue;
        PatchChange change(patch);
        const std::uint64_t edges = cut_spindles(patch, *stars, options.spindle, change);
        const std::uint64_t corners =
            edges > 0 ? 0 : cut_corners(patch, *stars, options.corner, change, stats.segments);
        stats.edges_split += edges;
        stats.vertices_split += corners;
        if (edges + corners > 0) {
            stats.points_added += change.points_added;
            stats.cells_added += change.cells_added;
            change.apply(patch);
            continue;
        }
        if (relabellings++ == most_relabellings) break;
        const std::uint64_t relabelled = relabel_components(patch, *stars);
        stats.components_relabelled += relabelled;
        if (relabelled == 0) break;
    }
    return stays_nonmanifold(patch, stars->nonmanifold);
}

}  // namespace anatomesh
