// Laws of outlying slices on random drawings: of each kind of mistake nearly all are named, and of right slices hardly any.
// The environment variable ANATOMESH_WRONG_SLICES = "400" runs so many drawings and prints tables; ANATOMESH_WRONG_SLICES_EACH
// prints what was missed too.
#include "anatomesh/outliers/outlying_slices.h"

#include <gtest/gtest.h>

#include <array>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "anatomesh/contour/cleaned_for_test.h"
#include "anatomesh/outliers/shape_of_structure.h"
#include "anatomesh/outliers/warn_about_outlying_slices.h"
#include "anatomesh/outliers/wrong_slices_for_test.h"

namespace anatomesh::outlying_slices_test {
namespace {

using namespace wrong_slices;

// Random drawings by default. Each offers a place for some of the mistakes.
constexpr std::uint32_t usual_drawings = 40;
// Hands move each slice by so much at most.
constexpr std::array<double, 2> shakes_mm{0, 0.4};
// Of right slices so many may be named, and of mistakes of all kinds so many must be.
constexpr double most_named = 0.01, least_found = 0.93;

std::uint32_t drawings() {
    const char* text = std::getenv("ANATOMESH_WRONG_SLICES");
    std::uint32_t count = usual_drawings;
    if (text) std::from_chars(text, text + std::string_view(text).size(), count);
    return count;
}
bool prints() {
    return std::getenv("ANATOMESH_WRONG_SLICES") != nullptr;
}
bool prints_each() {
    return std::getenv("ANATOMESH_WRONG_SLICES_EACH") != nullptr;
}

std::vector<OutlyingSlice> outliers_in(const ContourSet& set, int threads = 1) {
    RunContext context;
    context.threads = threads;
    return find_outlying_slices(set, arrangement_of(set), context);
}

// The names of the slices, in order.
std::vector<std::string> named(const ContourSet& set) {
    std::vector<std::string> names;
    for (const OutlyingSlice& one : outliers_in(set)) names.push_back(set.slices[one.slice].name);
    return names;
}

std::optional<ContourSet> kept_of(const Drawing& drawing) {
    RunContext context;
    auto cleaned = clean_contours(raw_of(drawing), {}, context);
    if (!cleaned.ok()) return std::nullopt;
    return std::move(cleaned.value().kept);
}

std::string name_of_slice(std::size_t k) {
    return "slice " + std::to_string(k);
}

struct Counts {
    std::size_t found = 0, of = 0, besides = 0;
    void print(const char* what, const char* name, double shake_mm) const {
        if (prints())
            std::printf("%s, hands %.1f mm, %-20s %4zu of %4zu, besides %zu\n", what, shake_mm, name, found,
                        of, besides);
    }
    void add(const Counts& other) {
        found += other.found;
        of += other.of;
        besides += other.besides;
    }
};

TEST(OutlyingSlices, of_right_slices_hardly_any_is_named) {
    for (const double shake : shakes_mm) {
        std::array<Counts, families> by_family;
        std::array<Counts, plane_sets> by_planes;
        Counts all;
        for (std::uint32_t n = 0; n < drawings(); ++n) {
            const Drawing drawing = drawing_of(n, shake);
            const std::optional<ContourSet> set = kept_of(drawing);
            if (!set) continue;
            const Counts counts{named(*set).size(), set->slices.size(), 0};
            by_family[static_cast<std::size_t>(drawing.family)].add(counts);
            by_planes[static_cast<std::size_t>(drawing.arrangement)].add(counts);
            all.add(counts);
            if (prints_each() && counts.found > 0) std::printf("named: %s\n", drawing.name.c_str());
        }
        for (std::size_t f = 0; f < families; ++f) by_family[f].print("right", family_names[f], shake);
        for (std::size_t p = 0; p < plane_sets; ++p) by_planes[p].print("right", plane_set_names[p], shake);
        EXPECT_LE(static_cast<double>(all.found), most_named * static_cast<double>(all.of)) << shake;
    }
}

// A mistake is found if a slice with it is named.
Counts found_of(Mistake mistake, double shake_mm) {
    Counts counts;
    for (std::uint32_t n = 0; n < drawings(); ++n) {
        const std::optional<Wrong> wrong = wrong_of(n, mistake, shake_mm);
        if (!wrong) continue;
        const std::optional<ContourSet> set = kept_of(wrong->drawing);
        if (!set) continue;
        std::size_t right_ones = 0, wrong_ones = 0;
        for (const std::string& name : named(*set)) {
            const bool is_wrong = std::any_of(wrong->slices.begin(), wrong->slices.end(),
                                              [&](std::size_t k) { return name == name_of_slice(k); });
            ++(is_wrong ? wrong_ones : right_ones);
        }
        ++counts.of;
        counts.found += wrong_ones > 0;
        counts.besides += right_ones;
        if (prints_each() && wrong_ones == 0)
            std::printf("missed: %s, slice %zu: %s\n", mistake_names[static_cast<std::size_t>(mistake)],
                        wrong->slices[0], wrong->drawing.name.c_str());
    }
    return counts;
}

TEST(OutlyingSlices, mistakes_are_named) {
    for (const double shake : shakes_mm) {
        if (!prints() && shake > 0) continue;  // for time
        Counts all;
        for (std::size_t m = 0; m < mistakes; ++m) {
            const Counts counts = found_of(static_cast<Mistake>(m), shake);
            counts.print("mistake", mistake_names[m], shake);
            all.add(counts);
        }
        all.print("mistake", "all", shake);
        EXPECT_GE(static_cast<double>(all.found), least_found * static_cast<double>(all.of)) << shake;
    }
}

TEST(OutlyingSlices, are_the_same_at_any_number_of_threads) {
    for (const std::uint32_t n : {4u, 16u, 33u}) {
        const std::optional<Wrong> wrong = wrong_of(n, Mistake::twice_as_wide);
        ASSERT_TRUE(wrong);
        const std::optional<ContourSet> set = kept_of(wrong->drawing);
        ASSERT_TRUE(set);
        const std::vector<OutlyingSlice> one = outliers_in(*set, 1), three = outliers_in(*set, 3);
        ASSERT_EQ(one.size(), three.size());
        for (std::size_t k = 0; k < one.size(); ++k) {
            EXPECT_EQ(one[k].slice, three[k].slice);
            EXPECT_EQ(one[k].area_mm2, three[k].area_mm2);
        }
    }
}

// An organ on `count` slices 3 mm apart whose outline's middle and radius follow the height.
ContourSet organ(int count, const std::function<Vec3(int)>& middle_and_radius) {
    fixtures::File file;
    for (int k = 0; k < count; ++k) {
        const Vec3 at = middle_and_radius(k);
        file.add(fixtures::circle(at.x, at.y, at.z, 50, 3.0 * k));
    }
    return fixtures::clean(file).kept();
}

std::vector<std::uint32_t> displaced_in(const ContourSet& set) {
    std::vector<std::uint32_t> slices;
    for (const OutlyingSlice& one : outliers_in(set)) {
        if (one.kind == OutlierKind::displaced) slices.push_back(one.slice);
    }
    return slices;
}

Vec3 ball(int k) {
    return {0, 0, std::sqrt(30.0 * 30 - 9 * (k - 8) * (k - 8))};
}

TEST(OutlyingSlices, C29_a_slice_that_jumped_is_named_with_its_distance) {
    for (const double jump : {4.0, 8.0, 12.0, 40.0}) {
        for (const int at : {3, 8, 12}) {
            const ContourSet set = organ(17, [&](int k) { return ball(k) + Vec3{k == at ? jump : 0, 0, 0}; });
            const std::vector<OutlyingSlice> found = outliers_in(set);
            ASSERT_EQ(found.size(), 1u) << jump << " " << at;
            EXPECT_EQ(found[0].slice, static_cast<std::uint32_t>(at));
            EXPECT_EQ(found[0].kind, OutlierKind::displaced);
            EXPECT_NEAR(found[0].distance_mm, jump, 0.05);
        }
    }
}

TEST(OutlyingSlices, what_leans_bends_winds_trembles_or_jumps_for_good_is_not_named) {
    std::mt19937 random(5);
    std::normal_distribution<double> noise(0, 0.7);
    EXPECT_TRUE(named(organ(17, ball)).empty());
    EXPECT_TRUE(named(organ(17, [](int k) { return ball(k) + Vec3{2.5 * k, -1.0 * k, 0}; })).empty());
    EXPECT_TRUE(named(organ(17, [](int k) { return Vec3{0.2 * (k - 8) * (k - 8), 0, 8}; })).empty());
    EXPECT_TRUE(named(organ(17, [](int k) {
                    return Vec3{12 * std::cos(0.7 * k), 12 * std::sin(0.7 * k), 5};
                })).empty());
    EXPECT_TRUE(named(organ(17, [&](int k) {
                    return ball(k) + Vec3{noise(random), noise(random), 0};
                })).empty());
    EXPECT_TRUE(named(organ(17, [](int k) { return ball(k) + Vec3{k < 8 ? 0.0 : 10.0, 0, 0}; })).empty());
}

TEST(OutlyingSlices, a_process_that_comes_again_is_the_shape_and_a_larger_part_is_not_displaced) {
    fixtures::File process, kidneys;
    for (int k = 0; k < 15; ++k) {
        fixtures::Points outline = fixtures::circle(0, 0, 18, 60, 5.0 * k);
        if (k % 7 == 3) {
            for (Vec3& p : outline) p.x = p.x > 15 ? p.x + 20 : p.x;
        }
        process.add(outline);
        for (const double side : {-60.0, 60.0})
            kidneys.add(fixtures::circle(side, 0, k == 7 && side > 0 ? 22.2 : 20, 50, 5.0 * k));
    }
    EXPECT_TRUE(named(fixtures::clean(process).kept()).empty());
    EXPECT_TRUE(displaced_in(fixtures::clean(kidneys).kept()).empty());
}

TEST(OutlyingSlices, one_of_several_structures_that_lies_aside_is_named) {
    for (const bool both : {false, true}) {
        fixtures::File file;
        for (int k = 0; k < 17; ++k) {
            for (std::uint32_t s = 0; s < 2; ++s)
                file.add(
                    fixtures::circle(60.0 * s + (k == 8 && (both || s == 0) ? 10 : 0), 0, 20, 50, 3.0 * k),
                    s);
        }
        EXPECT_EQ(displaced_in(fixtures::clean(file).kept()), std::vector<std::uint32_t>{8}) << both;
    }
}

// On a slice that is left out all its structures go, and a grid that counts otherwise than a coarser one counts nothing.
TEST(OutlyingSlices, a_warning_says_what_else_goes_and_counts_only_what_two_grids_count) {
    fixtures::File file;
    for (int k = 0; k < 11; ++k) {
        file.add(fixtures::circle(0, 0, 10, 40, 3.0 * k));
        file.add(fixtures::circle(40, 0, 10, 40, 3.0 * k), 1);
        if (k == 5) file.add(fixtures::circle(0, 0, 9.7, 40, 3.0 * k));
    }
    const ContourSet set = fixtures::clean(file).kept();
    RunContext context;
    warn_about_outlying_slices(set, arrangement_of(set), {}, context);
    ASSERT_EQ(context.warnings.size(), 1u);
    EXPECT_NE(context.warnings[0].what_was_done.find("leaves it out, for all 2 structures that it draws"),
              std::string::npos)
        << context.warnings[0].what_was_done;
    const Result<StructureShape> thin = shape_of_structure(set, 0, {}, context);
    ASSERT_TRUE(thin.ok());
    EXPECT_FALSE(thin.value().is_counted)
        << thin.value().parts << " parts, " << thin.value().tunnels << " tunnels";
    const Result<StructureShape> whole = shape_of_structure(set, 1, {}, context);
    ASSERT_TRUE(whole.ok());
    EXPECT_TRUE(whole.value().is_counted);
    EXPECT_EQ(whole.value().parts, 1u);
}

TEST(OutlyingSlices, a_warning_says_what_is_wrong_and_how_to_leave_it_out) {
    fixtures::File file;
    for (int k = 0; k < 11; ++k) {
        file.add(fixtures::circle(0, 0, 10, 40, 3.0 * k));
        if (k == 5) file.add(fixtures::circle(0, 0, 9, 40, 3.0 * k));
    }
    const fixtures::Cleaned cleaned = fixtures::clean(file);
    RunContext context;
    ContourSet set = cleaned.kept();
    warn_about_outlying_slices(set, arrangement_of(set), {}, context);
    ASSERT_EQ(context.warnings.size(), 1u);
    const Warning& warning = context.warnings[0];
    EXPECT_EQ(warning.code, "W-FLD-020");
    EXPECT_EQ(warning.place.slice, set.slices[5].name);
    EXPECT_EQ(warning.place.structure, "liver");
    EXPECT_NE(warning.message.find("hole where the slices before and after are solid"), std::string::npos);
    EXPECT_NE(warning.message.find("at (0.0, "), std::string::npos) << warning.message;
    EXPECT_NE(warning.what_was_done.find("in 1 part with 1 cavity, without it"), std::string::npos)
        << warning.what_was_done;
    EXPECT_NE(warning.what_was_done.find("--without '" + set.slices[5].name + "' leaves it out"),
              std::string::npos)
        << warning.what_was_done;
    // Voxels say all of each slice, and segmentations have parts of one slice.
    set.drawn = false;
    RunContext traced;
    warn_about_outlying_slices(set, arrangement_of(set), {}, traced);
    EXPECT_TRUE(traced.warnings.empty());
}

}  // namespace
}  // namespace anatomesh::outlying_slices_test
