// The library without the program: contours made here, one call to a model of them, a file, its certificate.
#include <anatomesh/pipeline/make_model.h>
#include <anatomesh_io/mesh/mesh_file.h>
#include <anatomesh_io/provenance/model_description.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

namespace {

using anatomesh::RawContour;
using anatomesh::RawContours;
using anatomesh::Vec3;

constexpr double radius = 10, spacing = 2;  // mm
constexpr int points = 48;                  // of a contour

// A closed contour: a circle round `center`, in the plane of the two directions.
void add_circle(RawContours& raw, std::uint32_t structure, Vec3 center, double r, Vec3 along, Vec3 across,
                const std::string& slice) {
    RawContour contour;
    contour.structure = structure;
    contour.slice = slice;
    contour.first_point = static_cast<std::uint32_t>(raw.points.size());
    contour.point_count = points;
    for (int i = 0; i < points; ++i) {
        const double a = 2 * std::numbers::pi * i / points;
        raw.points.push_back(center + r * std::cos(a) * along + r * std::sin(a) * across);
    }
    raw.contours.push_back(contour);
}

// Two balls that touch, drawn on slices along z and on one slice across them. Coordinates are LPS, mm.
RawContours two_balls() {
    RawContours raw;
    raw.structures.push_back({1, "left ball", {200, 80, 60}});
    raw.structures.push_back({2, "right ball", {60, 120, 200}});
    for (std::uint32_t ball = 0; ball < 2; ++ball) {
        const double x = ball == 0 ? -radius : radius;
        for (double z = -radius + spacing / 2; z < radius; z += spacing)
            add_circle(raw, ball, {x, 0, z}, std::sqrt(radius * radius - z * z), {1, 0, 0}, {0, 1, 0},
                       "z = " + std::to_string(static_cast<int>(z)));
        add_circle(raw, ball, {x, 0, 0}, radius, {1, 0, 0}, {0, 0, 1}, "coronal");
    }
    return raw;
}

// The same as a contour file that the program reads (docs/formats.md).
bool write_json(const RawContours& raw, const char* path) {
    std::FILE* const file = std::fopen(path, "w");
    if (file == nullptr) return false;
    std::fprintf(file, R"({"format": "anatomesh-contours", "version": 1, "space": "LPS", "unit": "mm",)");
    const char* before = R"( "structures": [)";
    for (const anatomesh::Structure& s : raw.structures) {
        std::fprintf(file, R"(%s{"number": %d, "name": "%s", "color": [%d, %d, %d]})", before, s.number,
                     s.name.c_str(), s.color[0], s.color[1], s.color[2]);
        before = ", ";
    }
    before = "],\n \"slices\": [";
    for (const RawContour& contour : raw.contours) {
        std::fprintf(file, R"(%s{"name": "%s", "contours": [{"structure": %d, "points": )", before,
                     contour.slice.c_str(), raw.structures[contour.structure].number);
        before = "[";
        for (std::uint32_t i = contour.first_point; i < contour.first_point + contour.point_count; ++i) {
            const Vec3 p = raw.points[i];
            std::fprintf(file, "%s[%.17g, %.17g, %.17g]", before, p.x, p.y, p.z);
            before = ", ";
        }
        std::fprintf(file, "]}]}");
        before = ",\n";
    }
    std::fprintf(file, "]}\n");
    return std::fclose(file) == 0;
}

int failed(const anatomesh::Error& error) {
    std::fprintf(stderr, "%s\n", anatomesh::to_line(error).c_str());
    return 1;
}

}  // namespace

int main() {
    const RawContours contours = two_balls();
    if (!write_json(contours, "two_balls.json")) return 1;

    anatomesh::RunContext context;        // threads, cancelling, progress; warnings are gathered in it
    anatomesh::MakeModelOptions options;  // the program's defaults; options.prepare: of the contours
    options.size_mm = 1.5;
    const auto model = anatomesh::make_model(contours, options, context);
    if (!model) return failed(model.error());
    const auto written =
        anatomesh::write_model("two_balls.vtu", anatomesh::model_file(model.value()), context);
    if (!written) return failed(written.error());

    const anatomesh::ModelReport& report = model.value().report;
    std::printf("two_balls.vtu: %zu tetrahedra\n", model.value().mesh.cells.size());
    for (const anatomesh::StructureReport& structure : report.structures)
        std::printf("%s: %.1f mm3\n", structure.name.c_str(), structure.volume.mesh_mm3);
    for (const anatomesh::Clause& clause : report.certificate)
        std::printf("clause %d: %s\n", clause.number, clause.evidence.c_str());
    for (const anatomesh::Warning& warning : report.warnings)
        std::printf("warning: %s\n", anatomesh::to_line(warning).c_str());
    return 0;
}
