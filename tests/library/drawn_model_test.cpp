// A model of what is drawn beside the command's model of the saved contours: the same bytes, at any step of the drawing.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <string>
#include <vector>

#include "anatomesh/live/edit/drawn_contours.h"
#include "anatomesh/live/edit/edit_history.h"
#include "anatomesh/live/edit/make_edits.h"
#include "anatomesh/pipeline/make_model.h"
#include "anatomesh_io/contour/write_contours.h"
#include "anatomesh_io/mesh/mesh_file.h"
#include "anatomesh_io/provenance/model_description.h"

namespace anatomesh::drawn_model_test {
namespace {

namespace fs = std::filesystem;

std::vector<Vec3> circle(const Plane& plane, Vec2 middle, double radius) {
    std::vector<Vec3> ring;
    for (int i = 0; i < 24; ++i) {
        const double angle = 2 * std::numbers::pi * i / 24;
        ring.push_back(plane.to_space(middle + radius * Vec2{std::cos(angle), std::sin(angle)}));
    }
    return ring;
}

void apply(EditHistory& history, const Edit& edit) {
    const Status status = history.apply(edit);
    ASSERT_TRUE(status.ok()) << to_line(status.error());
}

// Two structures beside each other on seven leaning slices, one with a hole.
EditHistory drawn() {
    EditHistory history(Drawing({Frame::lps, 0.5, 4}));
    for (int s = 1; s <= 2; ++s)
        apply(history,
              add_structure(history.drawing(), {{10 - s, s == 1 ? "liver" : "tumour", {200, 80, 60}}, false},
                            "Add a structure"));
    for (int p = 1; p <= 7; ++p) {
        Plane plane = make_plane({1, 2, 4.0 * p}, {0.1, 0, 1});
        plane.u = std::cos(0.3) * plane.u + std::sin(0.3) * plane.v;  // the image is turned in its plane
        plane.v = cross(plane.normal, plane.u);
        apply(history,
              add_plane(history.drawing(), p, {plane, "k = " + std::to_string(p), 4, false}, "Add a plane"));
        DrawnRings liver;
        liver.add(circle(plane, {0, 0}, 14 - std::abs(p - 4)));
        if (p > 2 && p < 6) liver.add(circle(plane, {1, 0}, 5));
        apply(history, set_rings(history.drawing(), {p, 9}, liver, "Draw liver"));
        if (p < 3 || p > 5) continue;
        DrawnRings tumour;
        tumour.add(circle(plane, {30, 0}, 6));
        apply(history, set_rings(history.drawing(), {p, 8}, tumour, "Draw tumour"));
    }
    return history;
}

class DrawnModel : public ::testing::Test {
  protected:
    void SetUp() override {
        folder_ =
            fs::temp_directory_path() / ("anatomesh_drawn_" + std::to_string(static_cast<long>(::getpid())));
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

    std::string by_command(const Drawing& drawing) {
        const char* program = std::getenv("ANATOMESH_PROGRAM");
        if (program == nullptr) {
            ADD_FAILURE() << "ANATOMESH_PROGRAM names the program";
            return "no program";
        }
        RunContext context;
        EXPECT_TRUE(write_contours(drawn_contours(drawing), (folder_ / "c.json").string(), context).ok());
        const std::string model = (folder_ / "model.vtu").string();
        std::string line = "'" + std::string(program) + "' model '" + (folder_ / "c.json").string() +
                           "' --quiet --threads 2 -o '" + model + "'";
        for (const std::string& name : slices_left_out(drawing)) line += " --without '" + name + "'";
        EXPECT_EQ(std::system(line.c_str()), 0) << line;
        std::ifstream file(model, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }

    std::string by_library(const Drawing& drawing) {
        RunContext context;
        MakeModelOptions options;
        options.prepare.choice.without = slices_left_out(drawing);
        const auto model = make_model(raw_contours(drawing), options, context);
        if (!model.ok()) {
            ADD_FAILURE() << to_line(model.error());
            return "no model";
        }
        auto bytes = format_model("model.vtu", model_file(model.value()), context);
        EXPECT_TRUE(bytes.ok());
        return std::move(bytes).value();
    }

    void expect_same(const Drawing& drawing) {
        const std::string library = by_library(drawing), command = by_command(drawing);
        EXPECT_GT(command.size(), 1000u);
        EXPECT_TRUE(library == command) << library.size() << " and " << command.size() << " bytes";
    }

    fs::path folder_;
};

TEST_F(DrawnModel, is_that_of_the_saved_contours_after_steps_and_after_undo) {
    EditHistory history = drawn();
    expect_same(history.drawing());
    const std::string before = by_library(history.drawing());
    apply(history, move_plane(history.drawing(), 4, make_plane({1, 2, 16.5}, {0.1, 0, 1}), "Move k = 4"));
    DrawnPlane left_out = *history.drawing().plane(5);
    left_out.left_out = true;
    apply(history, change_plane(history.drawing(), 5, left_out, "Leave out k = 5"));
    expect_same(history.drawing());
    EXPECT_FALSE(by_library(history.drawing()) == before);
    EXPECT_TRUE(history.undo().value());
    EXPECT_TRUE(history.undo().value());
    EXPECT_TRUE(by_library(history.drawing()) == before);
}

}  // namespace
}  // namespace anatomesh::drawn_model_test
