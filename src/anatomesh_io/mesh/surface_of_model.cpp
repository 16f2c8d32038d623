#include "anatomesh_io/mesh/surface_of_model.h"

#include <cstddef>

#include "anatomesh/mesh/check/topology.h"

namespace anatomesh {

SurfaceFile surface_of(const ModelFile& model) {
    SurfaceFile file{extract_interfaces(model.mesh), model.description};
    for (const PointArray& array : model.arrays) {
        PointArray& on_surface = file.arrays.emplace_back(PointArray{array.name, {}});
        // The surface's points are those of the mesh that it uses, in their order.
        for (std::size_t v = 0; v < model.mesh.points.size(); ++v) {
            const std::size_t next = on_surface.values.size();
            if (next < file.surface.points.size() && file.surface.points[next] == model.mesh.points[v])
                on_surface.values.push_back(array.values[v]);
        }
    }
    return file;
}

}  // namespace anatomesh
