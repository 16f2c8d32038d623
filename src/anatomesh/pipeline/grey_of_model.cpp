#include "anatomesh/pipeline/grey_of_model.h"

#include <chrono>
#include <utility>

#include "anatomesh/base/plural.h"
#include "anatomesh/element/grey.h"

namespace anatomesh {

Result<GreyOfModel> grey_of_model(const TetMesh& mesh, const GreyImage& image, const std::string& file,
                                  RunContext& context) {
    const auto start = std::chrono::steady_clock::now();
    ANATOMESH_TRY(GreyResult grey, grey_values(mesh, image, {}, context));
    const GreyStats& stats = grey.stats;
    if (stats.cells_outside > 0) {
        context.warn(
            {"W-ELM-001",
             counted(stats.cells_outside, "tetrahedron lies", "tetrahedra lie") + " outside the image",
             {file, "", "", "", ""},
             "they got the values of the nearest voxels"});
    }
    GreyOfModel result;
    result.values = std::move(grey.values);
    result.stage.name = "grey";
    result.stage.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    result.stage.cells = mesh.cells.size();
    result.stage.figures = {{"samples", static_cast<double>(stats.samples)},
                            {"cells_outside", static_cast<double>(stats.cells_outside)},
                            {"cells_cut", static_cast<double>(stats.cells_cut)},
                            {"low", stats.low},
                            {"high", stats.high},
                            {"mean", stats.mean}};
    return result;
}

}  // namespace anatomesh
