// What is drawn, written as contours and read again, is what the pipeline would have got of the drawing itself.
#include "anatomesh/live/edit/drawn_contours.h"

#include <gtest/gtest.h>

#include <set>

#include "anatomesh/live/edit/drawing_for_test.h"
#include "anatomesh_io/contour/contour_test_support.h"
#include "anatomesh_io/contour/read_contours.h"
#include "anatomesh_io/contour/write_contours.h"

namespace anatomesh::drawn_contours_test {
namespace {

using namespace contour_test;
using namespace drawing_for_test;

void expect_same_bits(std::span<const Vec3> a, std::span<const Vec3> b) {
    EXPECT_TRUE(same_bits(a, b));
}

void expect_same(const RawContours& a, const RawContours& b) {
    ASSERT_EQ(a.structures.size(), b.structures.size());
    for (std::size_t s = 0; s < a.structures.size(); ++s) {
        EXPECT_EQ(a.structures[s].number, b.structures[s].number);
        EXPECT_EQ(a.structures[s].name, b.structures[s].name);
        EXPECT_EQ(a.structures[s].color, b.structures[s].color);
    }
    ASSERT_EQ(a.contours.size(), b.contours.size());
    for (std::size_t c = 0; c < a.contours.size(); ++c) {
        const RawContour &p = a.contours[c], &q = b.contours[c];
        EXPECT_EQ(p.structure, q.structure);
        EXPECT_EQ(p.kind, q.kind);
        EXPECT_EQ(p.first_point, q.first_point);
        EXPECT_EQ(p.point_count, q.point_count);
        EXPECT_EQ(p.plane, q.plane);
        EXPECT_EQ(p.name, q.name);
        EXPECT_EQ(p.space, q.space);
        EXPECT_EQ(p.slice, q.slice);
        EXPECT_EQ(p.is_hole, q.is_hole);
    }
    expect_same_bits(a.points, b.points);
    ASSERT_EQ(a.planes.size(), b.planes.size());
    for (std::size_t s = 0; s < a.planes.size(); ++s) {
        const Plane &p = a.planes[s], &q = b.planes[s];
        expect_same_bits(std::vector{p.origin, p.u, p.v, p.normal},
                         std::vector{q.origin, q.u, q.v, q.normal});
    }
    EXPECT_EQ(a.plane_names, b.plane_names);
    EXPECT_EQ(a.frame, b.frame);
    EXPECT_EQ(a.pixel_mm, b.pixel_mm);
    EXPECT_EQ(a.slice_thickness_mm, b.slice_thickness_mm);
    EXPECT_EQ(a.complete, b.complete);
    EXPECT_EQ(a.exclusive, b.exclusive);
    EXPECT_EQ(a.unit_is_given, b.unit_is_given);
}

class DrawnContours : public testing::TestWithParam<unsigned> {
  protected:
    RawContours written_and_read(const Drawing& drawing) {
        const std::string path = folder_.file("contours.json");
        EXPECT_TRUE(write_contours(drawn_contours(drawing), path, context_).ok());
        auto read = read_contours(path, {}, context_);
        EXPECT_TRUE(read.ok()) << to_line(read.error());
        return read.ok() ? std::move(read).value() : RawContours{};
    }

    Folder folder_;
    RunContext context_;
};

TEST_P(DrawnContours, written_and_read_are_those_of_the_drawing) {
    RandomSteps steps(GetParam());
    const Frame frame = GetParam() % 4 == 0 ? Frame::unknown : Frame::lps;
    EditHistory history(Drawing({frame, GetParam() % 2 * 0.7, GetParam() % 3 * 2.5}));
    int compared = 0;
    for (int n = 0; n < 200; ++n) {
        ASSERT_TRUE(history.apply(steps.step(history.drawing())).ok());
        if (n % 10 != 0 || history.drawing().rings().entries().empty()) continue;
        expect_same(written_and_read(history.drawing()), raw_contours(history.drawing()));
        ++compared;
    }
    EXPECT_GT(compared, 10);
}

TEST_P(DrawnContours, slices_have_names_that_no_other_has_and_those_left_out_are_among_them) {
    RandomSteps steps(GetParam());
    EditHistory history;
    while (history.drawing().rings().entries().size() < 5)
        ASSERT_TRUE(history.apply(steps.step(history.drawing())).ok());
    const char* names[] = {"", "k = 1", "plane 1", "k = 1 (plane 2)"};
    const Drawing before = history.drawing();
    for (const auto& entry : before.planes().entries()) {
        DrawnPlane plane = *entry.value;
        plane.name = names[steps.below(4)];
        plane.left_out = steps.below(2) == 0;
        static_cast<void>(history.apply(change_plane(history.drawing(), entry.key, plane, "Name")));
    }
    const ContourSet set = drawn_contours(history.drawing());
    std::set<std::string> all;
    for (const Slice& slice : set.slices) {
        EXPECT_FALSE(slice.name.empty());
        EXPECT_GT(slice.contour_count, 0u);
        EXPECT_TRUE(all.insert(slice.name).second) << slice.name;
    }
    const std::vector<std::string> left_out = slices_left_out(history.drawing());
    std::size_t expected = 0;
    std::set<std::int32_t> planes;
    for (const auto& entry : history.drawing().rings().entries()) planes.insert(entry.key.plane);
    for (const std::int32_t id : planes) expected += history.drawing().plane(id)->left_out ? 1 : 0;
    EXPECT_EQ(left_out.size(), expected);
    for (const std::string& name : left_out) EXPECT_TRUE(all.contains(name));
}

INSTANTIATE_TEST_SUITE_P(seeds, DrawnContours, testing::Range(0u, 12u));

TEST_F(DrawnContours, negative_zeros_come_back) {
    const Plane plane = make_plane({-0.0, 0, -0.0}, {-0.0, 0, 1});
    Drawing drawing =
        applied(Drawing(), add_structure(Drawing(), {{4, "a", {1, 2, 3}}, false}, "Add")).value();
    drawing = applied(drawing, add_plane(drawing, 2, {plane, "k", 0, false}, "Add")).value();
    DrawnRings rings;
    rings.add(std::vector<Vec3>{{-0.0, 0, -0.0}, {9, -0.0, 0}, {0, 9, -0.0}});
    drawing = applied(drawing, set_rings(drawing, {2, 4}, rings, "Draw")).value();
    const RawContours read = written_and_read(drawing);
    expect_same(read, raw_contours(drawing));
    EXPECT_TRUE(std::signbit(read.points[0].x));
    EXPECT_TRUE(std::signbit(read.planes[0].origin.z));
    EXPECT_FALSE(std::signbit(read.points[0].y));
}

TEST_F(DrawnContours, proposals_and_planes_without_rings_are_no_contours) {
    std::mt19937 random(1);
    Drawing drawing =
        applied(Drawing(), add_structure(Drawing(), {{4, "a", {1, 2, 3}}, false}, "Add")).value();
    for (int p = 1; p <= 3; ++p) {
        const Plane plane = make_plane({0, 0, 3.0 * p}, {0, 0, 1});
        drawing = applied(drawing, add_plane(drawing, p, {plane, "", 0, false}, "Add")).value();
        const DrawnRings rings = star_rings(plane, random);
        const Edit edit = p == 2 ? set_rings(drawing, {p, 4}, rings, "Draw")
                                 : set_proposal(drawing, {p, 4}, rings, "Propose");
        if (p < 3) drawing = applied(drawing, edit).value();
    }
    const RawContours raw = raw_contours(drawing);
    EXPECT_EQ(raw.plane_names, std::vector<std::string>{"plane 2"});
    EXPECT_EQ(raw.contours.size(), 1u);
    expect_same(written_and_read(drawing), raw);
}

}  // namespace
}  // namespace anatomesh::drawn_contours_test
