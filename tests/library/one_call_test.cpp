// The library's one call beside the command: the same contours give the same bytes of a model.
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "anatomesh/pipeline/drawn_balls_for_test.h"
#include "anatomesh/pipeline/make_model.h"
#include "anatomesh_io/mesh/mesh_file.h"
#include "anatomesh_io/provenance/model_description.h"

namespace anatomesh::one_call_test {
namespace {

using fixtures::DrawnSet;
namespace fs = std::filesystem;

std::string number(double value) {
    std::array<char, 32> buffer;
    return {buffer.data(), std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr};
}

// A contour file (docs/formats.md), every contour a slice that gives no plane.
void write_json(const RawContours& raw, const fs::path& path) {
    std::ofstream file(path);
    file << R"({"format": "anatomesh-contours", "version": 1, "space": "LPS", "unit": "mm", "structures": [)";
    for (std::size_t s = 0; s < raw.structures.size(); ++s) {
        const Structure& each = raw.structures[s];
        file << (s > 0 ? ", " : "") << R"({"number": )" << each.number << R"(, "name": ")" << each.name
             << R"(", "color": [)" << int{each.color[0]} << ", " << int{each.color[1]} << ", "
             << int{each.color[2]} << "]}";
    }
    file << R"(], "slices": [)";
    for (std::size_t c = 0; c < raw.contours.size(); ++c) {
        const RawContour& contour = raw.contours[c];
        file << (c > 0 ? ",\n" : "") << R"({"name": ")" << contour.slice
             << R"(", "contours": [{"structure": )" << raw.structures[contour.structure].number
             << R"(, "points": [)";
        for (std::uint32_t i = 0; i < contour.point_count; ++i) {
            const Vec3 p = raw.points[contour.first_point + i];
            file << (i > 0 ? ", [" : "[") << number(p.x) << ", " << number(p.y) << ", " << number(p.z) << "]";
        }
        file << "]}]}";
    }
    file << "]}\n";
}

std::string bytes_of(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

class Command : public ::testing::TestWithParam<DrawnSet> {
  protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / ("anatomesh_one_call_" + GetParam().name + "_" +
                                               std::to_string(static_cast<long>(::getpid())));
        fs::create_directories(folder_);
        write_json(GetParam().raw, folder_ / "contours.json");
    }
    void TearDown() override { fs::remove_all(folder_); }

    // The model's file by the command, with these options.
    std::string by_command(const std::string& options) {
        const char* program = std::getenv("ANATOMESH_PROGRAM");
        if (program == nullptr) {
            ADD_FAILURE() << "ANATOMESH_PROGRAM names the program";
            return "no program";
        }
        std::string line = "'" + std::string(program) + "' model '" + (folder_ / "contours.json").string() +
                           "' --quiet -o '" + (folder_ / "model.vtu").string() + "' " + options;
        for (const std::string& name : GetParam().priority) line += " --priority '" + name + "'";
        EXPECT_EQ(std::system(line.c_str()), 0) << line;
        return bytes_of(folder_ / "model.vtu");
    }

    std::string by_library(MakeModelOptions options) {
        options.prepare.priority = GetParam().priority;
        RunContext context;
        const auto model = make_model(GetParam().raw, options, context);
        if (!model.ok()) {
            ADD_FAILURE() << to_line(model.error());
            return "no model";
        }
        auto bytes = format_model("model.vtu", model_file(model.value()), context);
        EXPECT_TRUE(bytes.ok());
        return std::move(bytes).value();
    }

    fs::path folder_;
};

void expect_same(const std::string& library, const std::string& command) {
    EXPECT_GT(command.size(), 1000u);
    EXPECT_TRUE(library == command) << library.size() << " and " << command.size() << " bytes";
}

TEST_P(Command, gives_the_same_bytes_by_default) {
    expect_same(by_library({}), by_command("--threads 2"));
}

TEST_P(Command, gives_the_same_bytes_with_options) {
    MakeModelOptions options;
    options.size_mm = 2.2;
    options.prepare.reconcile.max_disagreement_mm = 5;
    options.prepare.walls.same_line_mm = 0.01;
    options.prepare.field.caps = EndCaps::rounded;
    options.prepare.field.max_gap_spacings = 3;
    std::string command = "--size 2.2 --same-line 0.01 --caps rounded --max-gap 3";
    // The command refuses it where no slices cross.
    if (GetParam().name.starts_with("crossing")) command += " --max-disagreement 5";
    expect_same(by_library(options), by_command(command));
}

INSTANTIATE_TEST_SUITE_P(sets, Command, ::testing::ValuesIn(fixtures::drawn_sets()),
                         [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace anatomesh::one_call_test
