// Uses the installed library as another project would: the model of a ball from its contours, written to a file.
#include <anatomesh/contour/clean.h>
#include <anatomesh/pipeline/build_model.h>
#include <anatomesh_io/file/atomic_file.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

namespace {

constexpr double radius = 10, spacing = 2;

// Circles on parallel slices.
anatomesh::RawContours ball() {
    anatomesh::RawContours raw;
    raw.structures.push_back({1, "ball", {200, 200, 200}});
    for (double z = -radius + spacing / 2; z < radius; z += spacing) {
        anatomesh::RawContour contour;
        contour.first_point = static_cast<std::uint32_t>(raw.points.size());
        contour.point_count = 32;
        for (int i = 0; i < 32; ++i) {
            const double a = 2 * std::numbers::pi * i / 32, r = std::sqrt(radius * radius - z * z);
            raw.points.push_back({r * std::cos(a), r * std::sin(a), z});
        }
        raw.contours.push_back(contour);
    }
    return raw;
}

int failed(const anatomesh::Error& error) {
    std::fprintf(stderr, "%s\n", anatomesh::to_line(error).c_str());
    return 1;
}

}  // namespace

int main() {
    anatomesh::RunContext context;
    const auto cleaned = anatomesh::clean_contours(ball(), {}, context);
    if (!cleaned) return failed(cleaned.error());
    const auto model = anatomesh::build_model(cleaned.value().kept, {}, context);
    if (!model) return failed(model.error());
    const auto written = anatomesh::write_file_atomically(
        "ball.txt", std::to_string(model.value().mesh.cells.size()) + " tetrahedra\n");
    if (!written) return failed(written.error());
    return model.value().mesh.cells.empty() ? 1 : 0;
}
