#include "anatomesh/live/edit/edit.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "anatomesh/live/edit/drawing_for_test.h"

namespace anatomesh::edit_test {
namespace {

using namespace drawing_for_test;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Drawing with(const Drawing& drawing, const Edit& edit) {
    auto result = applied(drawing, edit);
    EXPECT_TRUE(result.ok()) << to_line(result.error());
    return result.ok() ? result.value() : drawing;
}

// Structures 1 and 2, planes 1 to 3 with rings of structure 1.
Drawing three_slices() {
    std::mt19937 random(5);
    Drawing drawing;
    for (int s = 1; s <= 2; ++s)
        drawing =
            with(drawing, add_structure(drawing, {{s, s == 1 ? "liver" : "", {1, 2, 3}}, false}, "Add"));
    for (int p = 1; p <= 3; ++p) {
        const DrawnPlane plane{make_plane({1, 2, 3.0 * p}, {0, 0.1, 1}),
                               p == 2 ? "" : "k = " + std::to_string(p), 0, false};
        drawing = with(drawing, add_plane(drawing, p, plane, "Add"));
        drawing = with(drawing, set_rings(drawing, {p, 1}, star_rings(plane.plane, random, 2), "Draw"));
    }
    return drawing;
}

Error error_of(const Drawing& drawing, const Edit& edit) {
    const auto result = applied(drawing, edit);
    return result.ok() ? Error{} : result.error();
}

// The rings of plane 1 with one of their points changed.
Edit with_point(const Drawing& drawing, std::size_t point, const std::function<void(Vec3&)>& change) {
    DrawnRings rings = *drawing.rings({1, 1});
    change(rings.points[point]);
    return set_rings(drawing, {1, 1}, rings, "Change a point");
}

TEST(Edit, an_unknown_structure_or_plane_is_refused_with_its_place) {
    const Drawing drawing = three_slices();
    std::mt19937 random(1);
    const DrawnRings rings = star_rings(drawing.plane(1)->plane, random);
    const Error structure = error_of(drawing, set_rings(drawing, {1, 99}, rings, "Draw"));
    EXPECT_EQ(structure.code, "E-EDT-002");
    EXPECT_EQ(structure.place.slice, "k = 1");
    EXPECT_EQ(structure.place.value, "99");
    EXPECT_EQ(error_of(drawing, set_proposal(drawing, {1, 99}, rings, "Draw")).code, "E-EDT-002");
    const Error plane = error_of(drawing, set_rings(drawing, {99, 1}, rings, "Draw"));
    EXPECT_EQ(plane.code, "E-EDT-003");
    EXPECT_EQ(plane.place.structure, "liver");
    for (const RingsKey& key : {RingsKey{99, 1}, RingsKey{1, 99}}) {
        const TopologyPin pin{{{1, 1}, {0, 0, 0}}, {key, {0, 0, 0}}, true};
        EXPECT_EQ(error_of(drawing, set_pin(drawing, 1, pin, "Pin")).code,
                  key.plane == 99 ? "E-EDT-003" : "E-EDT-002");
    }
    EXPECT_EQ(error_of(drawing, reorder_structures(drawing, {1, 2, 3}, "Order")).code, "E-EDT-010");
    EXPECT_EQ(error_of(drawing, reorder_structures(drawing, {2, 2}, "Order")).code, "E-EDT-010");
    EXPECT_EQ(error_of(drawing, reorder_structures(drawing, {2}, "Order")).code, "E-EDT-010");
    EXPECT_EQ(error_of(drawing, reorder_structures(drawing, {2, 1}, "Order")).code, "");
}

TEST(Edit, nothing_is_left_that_belongs_to_what_is_gone) {
    Drawing drawing = three_slices();
    const TopologyPin pin{{{2, 2}, {0, 0, 0}}, {{3, 1}, {0, 0, 0}}, false};
    drawing = with(drawing, set_pin(drawing, 1, pin, "Pin"));
    const auto removed = [&](const DrawingKey& key) {
        return Edit{"Remove", {{key, drawing.value(key), {}}}};
    };
    EXPECT_EQ(error_of(drawing, removed(DrawingKey::of_plane(1))).code, "E-EDT-003") << "rings";
    EXPECT_EQ(error_of(drawing, removed(DrawingKey::of_structure(1))).code, "E-EDT-002") << "rings";
    Edit structure = removed(DrawingKey::of_structure(2));
    structure.changes.push_back(
        {DrawingKey::of_order(), drawing.value(DrawingKey::of_order()), drawing_value(StructureOrder{1})});
    EXPECT_EQ(error_of(drawing, structure).code, "E-EDT-002") << "a pin";
    for (const Edit& edit : {remove_structure(drawing, 1, "Remove"), remove_structure(drawing, 2, "Remove"),
                             remove_plane(drawing, 2, "Remove"), remove_plane(drawing, 3, "Remove")}) {
        const Drawing after = with(drawing, edit);
        EXPECT_TRUE(after.pins().entries().empty());
        EXPECT_TRUE(same_drawing(with(after, inverse(edit)), drawing));
    }
}

TEST(Edit, a_plane_given_twice_is_refused) {
    const Drawing drawing = three_slices();
    const auto add = [&](Plane plane) {
        return error_of(drawing, add_plane(drawing, 9, {plane, "new", 0, false}, "Add"));
    };
    const Plane& one = drawing.plane(1)->plane;
    EXPECT_EQ(add(one).code, "E-EDT-004");
    EXPECT_NE(add(one).message.find("k = 1"), std::string::npos);
    EXPECT_EQ(add(make_plane(one.to_space({300, -70}), -one.normal)).code, "E-EDT-004")
        << "turned over, moved in itself";
    EXPECT_EQ(add(make_plane(one.origin + 1e-5 * one.normal, one.normal)).code, "");
    EXPECT_EQ(add(make_plane(one.origin, one.normal + 1e-8 * one.u)).code, "");
    EXPECT_EQ(error_of(drawing, move_plane(drawing, 2, one, "Move")).code, "E-EDT-004");
    Edit twice = add_plane(drawing, 8, {make_plane({0, 0, 99}, {0, 0, 1}), "", 0, false}, "Add");
    twice.changes.push_back(twice.changes[0]);
    twice.changes[1].key.first = 9;
    EXPECT_EQ(error_of(drawing, twice).code, "E-EDT-004");
    twice.changes[1].key.first = 8;
    EXPECT_EQ(error_of(drawing, twice).code, "E-EDT-001") << "one id twice";
}

TEST(Edit, what_is_no_plane_is_refused) {
    const Drawing drawing = three_slices();
    const auto code = [&](const std::function<void(DrawnPlane&)>& spoil) {
        DrawnPlane plane{make_plane({0, 0, 50}, {0, 0, 1}), "", 0, false};
        spoil(plane);
        return error_of(drawing, add_plane(drawing, 9, plane, "Add")).code;
    };
    EXPECT_EQ(code([](DrawnPlane&) {}), "");
    EXPECT_EQ(code([](DrawnPlane& p) { p.plane.origin.x = nan; }), "E-EDT-011");
    EXPECT_EQ(code([](DrawnPlane& p) { p.plane.origin.x = 2e7; }), "E-EDT-011");
    EXPECT_EQ(code([](DrawnPlane& p) { p.plane.normal = {0, 0, 0}; }), "E-EDT-011");
    EXPECT_EQ(code([](DrawnPlane& p) { p.plane.normal = {0, 0, 1 + 1e-9}; }), "E-EDT-011");
    EXPECT_EQ(code([](DrawnPlane& p) { p.plane.u = {nan, 0, 0}; }), "E-EDT-011");
    EXPECT_EQ(code([](DrawnPlane& p) { std::swap(p.plane.u, p.plane.v); }), "E-EDT-011");
    EXPECT_EQ(code([](DrawnPlane& p) { p.thickness_mm = -1; }), "E-EDT-011");
    EXPECT_EQ(code([](DrawnPlane& p) { p.thickness_mm = nan; }), "E-EDT-011");
    EXPECT_EQ(code([](DrawnPlane& p) { p.name = "\xFF"; }), "E-EDT-013");
}

TEST(Edit, bad_rings_are_refused_with_ring_and_point) {
    const Drawing drawing = three_slices();
    const Vec3 up = drawing.plane(1)->plane.normal;
    for (const std::size_t point : {0u, 5u, 11u, 12u, 23u}) {
        const std::string place = std::to_string(point / 12) + ", point " + std::to_string(point % 12);
        const Error off = error_of(drawing, with_point(drawing, point, [&](Vec3& p) { p += 0.02 * up; }));
        EXPECT_EQ(off.code, "E-EDT-005");
        EXPECT_EQ(off.place.contour, place);
        EXPECT_EQ(off.place.slice, "k = 1");
        EXPECT_EQ(off.place.structure, "liver");
        EXPECT_EQ(error_of(drawing, with_point(drawing, point, [&](Vec3& p) { p += 0.005 * up; })).code, "");
        for (const double value : {nan, std::numeric_limits<double>::infinity(), 1e8}) {
            const Error lost = error_of(drawing, with_point(drawing, point, [&](Vec3& p) { p.y = value; }));
            EXPECT_EQ(lost.code, "E-EDT-006");
            EXPECT_EQ(lost.place.contour, place);
        }
    }
    for (const int points : {1, 2}) {
        std::mt19937 random(1);
        const Error few = error_of(
            drawing,
            set_rings(drawing, {1, 1}, star_rings(drawing.plane(1)->plane, random, 1, points), "Draw"));
        EXPECT_EQ(few.code, "E-EDT-007");
        EXPECT_EQ(few.place.value, std::to_string(points));
    }
    EXPECT_EQ(
        error_of(drawing, {"Draw", {{DrawingKey::of_rings({1, 2}), {}, drawing_value(DrawnRings{})}}}).code,
        "E-EDT-007");
    DrawnRings spline = *drawing.rings({1, 1});
    spline.add(spline.points_of(spline.rings[0]), RingTool::spline, std::vector<Vec3>{{nan, 0, 0}});
    spline.rings.erase(spline.rings.begin());
    EXPECT_EQ(error_of(drawing, set_rings(drawing, {1, 1}, spline, "Draw")).code, "E-EDT-006");
}

TEST(Edit, rings_that_cross_are_refused_and_rings_that_touch_are_not) {
    const Drawing drawing = three_slices();
    const Plane& plane = drawing.plane(1)->plane;
    const auto code = [&](std::vector<std::vector<Vec2>> rings,
                          CrossingCheck crossings = CrossingCheck::yes) {
        DrawnRings drawn;
        for (const auto& ring : rings) {
            std::vector<Vec3> points;
            for (const Vec2 p : ring) points.push_back(plane.to_space(p));
            drawn.add(points);
        }
        const auto result = applied(drawing, set_rings(drawing, {1, 2}, drawn, "Draw"), crossings);
        return result.ok() ? std::string() : result.error().code;
    };
    const std::vector<Vec2> square{{0, 0}, {10, 0}, {10, 10}, {0, 10}};
    const std::vector<Vec2> bow{{0, 0}, {10, 10}, {10, 0}, {0, 10}};
    const auto moved = [&](double x, double y) {
        std::vector<Vec2> ring = square;
        for (Vec2& p : ring) p = p + Vec2{x, y};
        return ring;
    };
    EXPECT_EQ(code({square}), "");
    EXPECT_EQ(code({bow}), "E-EDT-008");
    EXPECT_EQ(code({bow}, CrossingCheck::no), "");
    EXPECT_EQ(code({square, moved(5, 5)}), "E-EDT-008");
    EXPECT_EQ(code({square, moved(20, 5)}), "");
    EXPECT_EQ(code({square, square}), "E-EDT-008");
    EXPECT_EQ(code({square, {{2, 2}, {4, 2}, {4, 4}}}), "") << "a hole";
    EXPECT_EQ(code({{{0, 0}, {10, 0}, {10, 0}, {10, 10}}}), "") << "a repeated point crosses nothing";
}

TEST(Edit, a_lock_bars_rings_proposals_and_removal_and_lets_names_and_colours_be) {
    Drawing drawing = three_slices();
    DrawnStructure liver = *drawing.structure(1);
    liver.locked = true;
    drawing = with(drawing, change_structure(drawing, liver, "Lock"));
    std::mt19937 random(1);
    const DrawnRings rings = star_rings(drawing.plane(1)->plane, random);
    for (const Edit& edit :
         {set_rings(drawing, {1, 1}, rings, "Draw"), set_rings(drawing, {1, 1}, std::nullopt, "Delete"),
          set_proposal(drawing, {1, 1}, rings, "Propose"), remove_structure(drawing, 1, "Delete"),
          remove_plane(drawing, 1, "Delete"), move_plane(drawing, 1, random_plane(random), "Move")}) {
        const Error error = error_of(drawing, edit);
        EXPECT_EQ(error.code, "E-EDT-009") << edit.name;
        EXPECT_EQ(error.place.structure, "liver");
    }
    liver.structure.name = "Leber";
    EXPECT_EQ(error_of(drawing, change_structure(drawing, liver, "Rename")).code, "");
    EXPECT_EQ(error_of(drawing, set_rings(drawing, {1, 2}, rings, "Draw")).code, "");
}

TEST(Edit, of_two_windows_the_second_is_refused_with_both_values) {
    const Drawing drawing = three_slices();
    std::mt19937 random(1);
    const Plane& plane = drawing.plane(1)->plane;
    const Edit one = set_rings(drawing, {1, 1}, star_rings(plane, random, 1, 7), "Window 1");
    const Edit other = set_rings(drawing, {1, 1}, star_rings(plane, random, 3, 5), "Window 2");
    const Drawing after = with(drawing, one);
    const Error error = error_of(after, other);
    EXPECT_EQ(error.code, "E-EDT-001");
    EXPECT_EQ(error.place.slice, "k = 1");
    EXPECT_EQ(error.place.structure, "liver");
    EXPECT_NE(error.message.find("expected is 2 rings with 24 points, there is 1 ring with 7 points"),
              std::string::npos)
        << error.message;
    EXPECT_TRUE(same_value(other.changes[0].before, drawing.value(other.changes[0].key)));
    EXPECT_EQ(error_of(after, set_rings(drawing, {2, 1}, std::nullopt, "Window 2")).code, "")
        << "another key";
    // One bit is enough.
    const Edit zero = with_point(drawing, 3, [](Vec3& p) { p.x = std::nextafter(p.x, 1e9); });
    EXPECT_EQ(error_of(with(drawing, zero), other).code, "E-EDT-001");
}

TEST(Edit, a_change_that_changes_nothing_and_a_name_that_is_no_text_are_refused) {
    const Drawing drawing = three_slices();
    EXPECT_EQ(error_of(drawing, {"Look", {}}).code, "E-EDT-012");
    EXPECT_EQ(error_of(drawing, change_structure(drawing, *drawing.structure(1), "Rename")).code,
              "E-EDT-012");
    const DrawingValue same = drawing.value(DrawingKey::of_rings({1, 1}));
    EXPECT_EQ(error_of(drawing, {"Draw", {{DrawingKey::of_rings({1, 1}), same, same}}}).code, "E-EDT-012");
    EXPECT_EQ(error_of(drawing, set_rings(drawing, {1, 1}, std::nullopt, "\xC3")).code, "E-EDT-013");
    EXPECT_EQ(error_of(drawing, set_rings(drawing, {1, 1}, std::nullopt, std::string("a\0b", 3))).code,
              "E-EDT-013");
    DrawnStructure renamed = *drawing.structure(1);
    renamed.structure.name = std::string((std::size_t{1} << 20) + 1, 'x');
    EXPECT_EQ(error_of(drawing, change_structure(drawing, renamed, "Rename")).code, "E-EDT-013");
}

TEST(Edit, a_turned_plane_carries_what_lies_on_it) {
    Drawing drawing = three_slices();
    const Vec3 pinned = drawing.rings({1, 1})->points[4];
    drawing =
        with(drawing, set_pin(drawing, 1, TopologyPin{{{1, 1}, pinned}, {{2, 1}, pinned}, true}, "Pin"));
    const Plane from = drawing.plane(1)->plane, to = make_plane({50, 60, 70}, {1, 2, -3});
    const Drawing after = with(drawing, move_plane(drawing, 1, to, "Turn"));
    const DrawnRings &before = *drawing.rings({1, 1}), &now = *after.rings({1, 1});
    for (std::size_t i = 0; i < now.points.size(); ++i) {
        const Vec2 p = from.to_plane(before.points[i]), q = to.to_plane(now.points[i]);
        EXPECT_NEAR(p.x, q.x, 1e-12);
        EXPECT_NEAR(p.y, q.y, 1e-12);
        EXPECT_NEAR(to.signed_distance(now.points[i]), 0, 1e-12);
    }
    EXPECT_EQ((*after.pins().find(1))->first.point, now.points[4]);
    EXPECT_EQ((*after.pins().find(1))->second.point, pinned);
    EXPECT_EQ(after.rings({2, 1}), drawing.rings({2, 1})) << "shared";
}

TEST(Edit, zeros_of_both_signs_are_two_values) {
    Drawing drawing = three_slices();
    const Plane axial = make_plane({0, 0, 0}, {0, 0, 1});
    drawing = with(drawing, add_plane(drawing, 9, {axial, "", 0, false}, "Add"));
    DrawnRings rings;
    rings.add(std::vector<Vec3>{{0, 0, 0}, {9, 0, 0}, {0, 9, 0}});
    drawing = with(drawing, set_rings(drawing, {9, 1}, rings, "Draw"));
    rings.points[0].z = -0.0;
    const Drawing after = with(drawing, set_rings(drawing, {9, 1}, rings, "Draw"));
    EXPECT_FALSE(same_drawing(drawing, after));
    EXPECT_TRUE(std::signbit(after.rings({9, 1})->points[0].z));
}

TEST(Drawing, a_copy_stays_what_it_was) {
    const Drawing drawing = three_slices();
    const Drawing copy = drawing;
    const Drawing after = with(drawing, remove_structure(drawing, 1, "Delete"));
    EXPECT_TRUE(same_drawing(copy, drawing));
    EXPECT_EQ(drawing.rings().entries().size(), 3u);
    EXPECT_EQ(copy.rings().entries().data(), drawing.rings().entries().data()) << "shared";
    EXPECT_TRUE(after.rings().entries().empty());
    EXPECT_EQ(copy.planes().entries().data(), after.planes().entries().data())
        << "untouched tables are shared";
    EXPECT_EQ(next_structure_number(drawing), 3);
    EXPECT_EQ(next_plane_id(drawing), 4);
    EXPECT_EQ(next_pin_id(drawing), 1);
    EXPECT_EQ(label_of_structure(drawing, 2), "number 2");
    EXPECT_EQ(label_of_plane(drawing, 2), "plane 2");
}

}  // namespace
}  // namespace anatomesh::edit_test
