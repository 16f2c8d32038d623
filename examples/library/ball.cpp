// The library without the program: contours made here, a model of them, its certificate, a file.
#include <anatomesh/contour/clean/clean.h>
#include <anatomesh/pipeline/build_model.h>
#include <anatomesh_io/mesh/mesh_file.h>

#include <cmath>
#include <cstdio>
#include <numbers>

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
    anatomesh::RunContext context;  // threads, cancelling, progress; warnings are gathered in it
    const auto cleaned = anatomesh::clean_contours(ball(), {}, context);
    if (!cleaned) return failed(cleaned.error());
    const auto model = anatomesh::build_model(cleaned.value().kept, {}, context);
    if (!model) return failed(model.error());

    anatomesh::ModelFile file;
    file.mesh = model.value().mesh;
    file.description.structures = model.value().structures;
    file.description.regions = model.value().regions;
    const auto written = anatomesh::write_model("ball.vtu", file, context);
    if (!written) return failed(written.error());

    const anatomesh::ModelReport& report = model.value().report;
    std::printf("ball.vtu: %zu tetrahedra, %.1f mm3\n", file.mesh.cells.size(),
                report.structures.front().volume_mesh_mm3);
    for (const anatomesh::Clause& clause : report.certificate) {
        std::printf("clause %d: %s\n", clause.number, clause.evidence.c_str());
    }
    return 0;
}
