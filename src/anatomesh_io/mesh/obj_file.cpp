// Wavefront .obj: vertices and faces; a group per pair of regions.
#include <algorithm>

#include "anatomesh_io/file/byte_reader.h"
#include "anatomesh_io/mesh/description.h"
#include "anatomesh_io/mesh/formats.h"
#include "anatomesh_io/mesh/mesh_text.h"

namespace anatomesh {

namespace {

constexpr std::string_view group_name = "interface_";

class ObjReader {
  public:
    ObjReader(const std::string& path, std::string_view text) : path_(path), reader_(path), lines_(text) {}
    Result<SurfaceFile> run(RunContext& context);

  private:
    Status vertex(std::string_view rest);
    Status face(std::string_view rest);
    void group(std::string_view rest);

    const std::string& path_;
    DescriptionReader reader_;
    Lines lines_;
    SurfaceMesh mesh_;
    std::vector<std::int64_t> inner_, outer_;  // per triangle
    std::int64_t group_inner_ = 0, group_outer_ = 0;
    bool all_grouped_ = true, in_group_ = false;
    std::size_t polygons_ = 0;
};

Status ObjReader::vertex(std::string_view rest) {
    Vec3 point;
    for (double* coordinate : {&point.x, &point.y, &point.z}) {
        const auto value = take_number<double>(rest);
        if (!value) return expected(path_, "a coordinate", lines_.place());
        *coordinate = *value;
    }
    ANATOMESH_CHECK_STATUS(check_point(point, mesh_.points.size(), path_));
    mesh_.points.push_back(point);
    return Nothing{};
}

// "f 1/2/3 4//5 -1": the first number of each is the vertex, negative ones count back from the last.
Status ObjReader::face(std::string_view rest) {
    std::vector<std::uint32_t> corners;
    for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest)) {
        const auto number = number_of<std::int64_t>(word.substr(0, word.find('/')));
        if (!number) return expected(path_, "the number of a vertex", lines_.place());
        const auto count = static_cast<std::int64_t>(mesh_.points.size());
        if (*number == 0 || *number > count || *number < -count) {
            return mesh_error(
                "E-MDL-004",
                "a face names vertex " + std::to_string(*number) + " of " + std::to_string(count), path_,
                lines_.place());
        }
        corners.push_back(static_cast<std::uint32_t>(*number > 0 ? *number - 1 : count + *number));
    }
    if (corners.size() < 3) return expected(path_, "a face of at least three vertices", lines_.place());
    if (corners.size() > 3) ++polygons_;
    all_grouped_ = all_grouped_ && in_group_;
    for (std::size_t i = 2; i < corners.size(); ++i) {
        mesh_.triangles.push_back({corners[0], corners[i - 1], corners[i]});
        inner_.push_back(group_inner_);
        outer_.push_back(group_outer_);
    }
    return Nothing{};
}

void ObjReader::group(std::string_view rest) {
    std::string_view name = take_word(rest);
    in_group_ = name.starts_with(group_name);
    if (!in_group_) return;
    name.remove_prefix(group_name.size());
    const std::size_t bar = std::min(name.find('_'), name.size());
    const auto inner = number_of<std::int64_t>(name.substr(0, bar));
    const auto outer = number_of<std::int64_t>(name.substr(std::min(bar + 1, name.size())));
    in_group_ = inner && outer;
    group_inner_ = inner.value_or(0);
    group_outer_ = outer.value_or(0);
}

Result<SurfaceFile> ObjReader::run(RunContext& context) {
    while (const auto line = lines_.next()) {
        std::string_view rest = *line;
        const std::string_view word = take_word(rest);
        if (word == "v") {
            ANATOMESH_CHECK_STATUS(vertex(rest));
        } else if (word == "f") {
            ANATOMESH_CHECK_STATUS(face(rest));
        } else if (word == "g") {
            group(rest);
        } else if (word == "#") {
            ANATOMESH_CHECK_STATUS(reader_.take(rest));
        }
    }
    if (mesh_.triangles.empty()) return mesh_error("E-MDL-008", "the file has no triangles", path_);
    if (mesh_.points.size() >= no_cell) return mesh_error("E-MDL-013", "more than 2^32 - 2 vertices", path_);
    warn_polygons(polygons_, path_, context);
    if (reader_.has_regions() && all_grouped_) {
        ANATOMESH_TRY(const std::vector<Region> inner, reader_.regions_of_indices(inner_));
        ANATOMESH_TRY(const std::vector<Region> outer, reader_.regions_of_indices(outer_));
        for (std::size_t i = 0; i < inner.size(); ++i) mesh_.sides.push_back({inner[i], outer[i]});
    }
    return SurfaceFile{std::move(mesh_), reader_.finish(context)};
}

}  // namespace

Result<std::string> format_obj(const std::string&, const SurfaceFile& surface, RunContext&) {
    const SurfaceMesh& mesh = surface.surface;
    std::string text;
    for (const std::string& line : description_lines(surface.description)) text += "# " + line + "\n";
    for (const Vec3& point : mesh.points) {
        text += 'v';
        for (const double coordinate : {point.x, point.y, point.z}) {
            text += ' ';
            append_number(text, coordinate);
        }
        text += '\n';
    }
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (!mesh.sides.empty() && (t == 0 || mesh.sides[t] != mesh.sides[t - 1])) {
            text += "g " + std::string(group_name) + std::to_string(mesh.sides[t][0]) + "_" +
                    std::to_string(mesh.sides[t][1]) + "\n";
        }
        text += 'f';
        for (const std::uint32_t vertex : mesh.triangles[t]) {
            text += ' ';
            append_number(text, std::uint64_t{vertex} + 1);
        }
        text += '\n';
    }
    return text;
}

Result<SurfaceFile> parse_obj(const std::string& path, Bytes content, RunContext& context) {
    return ObjReader(path, as_text(content)).run(context);
}

}  // namespace anatomesh
