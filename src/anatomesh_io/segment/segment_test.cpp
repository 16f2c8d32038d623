#include "anatomesh_io/segment/segment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "anatomesh_io/segment/segment_slices.h"

namespace anatomesh::segment_test {
namespace {

// A ball of value 100 in 20, noise of deviation `noise`, voxels of 1 x 1 x 1.5 mm, and its truth.
struct Phantom {
    GreyImage image;
    std::vector<std::uint8_t> truth;
    std::array<std::uint32_t, 3> centre{24, 22, 16};

    explicit Phantom(double noise, double radius = 14) {
        image.source = "phantom";
        image.geometry.size = {48, 44, 32};
        image.geometry.step = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1.5}};
        std::mt19937 random(3);
        std::normal_distribution<double> grain(0, noise);
        for (std::uint32_t k = 0; k < 32; ++k) {
            for (std::uint32_t j = 0; j < 44; ++j) {
                for (std::uint32_t i = 0; i < 48; ++i) {
                    const double d = std::hypot(i - 24.0, j - 22.0, 1.5 * (k - 16.0));
                    truth.push_back(d < radius);
                    image.voxels.push_back(
                        static_cast<float>((d < radius ? 100 : 20) + (noise > 0 ? grain(random) : 0)));
                }
            }
        }
    }
    double dice(const LabelMap& labels) const {
        double both = 0, sum = 0;
        for (std::size_t n = 0; n < truth.size(); ++n) {
            both += labels.voxels[n] != 0 && truth[n] != 0;
            sum += (labels.voxels[n] != 0) + (truth[n] != 0);
        }
        return 2 * both / sum;
    }
};

SegmentOptions with(SegmentMethod method, const Phantom& phantom) {
    SegmentOptions options;
    options.method = method;
    options.seeds = {phantom.centre};
    return options;
}

TEST(Segment, every_method_finds_a_ball_in_noise) {
    const Phantom phantom(8);
    for (const auto& [method, least] : {std::pair{SegmentMethod::threshold, 0.995},
                                        {SegmentMethod::otsu, 0.995},
                                        {SegmentMethod::grow, 0.995},
                                        {SegmentMethod::confidence, 0.95},
                                        {SegmentMethod::region, 0.92},
                                        {SegmentMethod::geodesic, 0.9},
                                        {SegmentMethod::chan_vese, 0.98}}) {
        RunContext context;
        SegmentOptions options = with(method, phantom);
        options.low = 60;
        options.iterations = 200;
        const auto result = segment_image(phantom.image, options, context);
        ASSERT_TRUE(result.ok()) << static_cast<int>(method) << to_line(result.error());
        EXPECT_GE(phantom.dice(result.value().labels), least) << static_cast<int>(method);
        // An active contour may be halted by the number of its steps.
        for (const Warning& warning : context.warnings) EXPECT_EQ(warning.code, "W-SGM-002");
        RunContext more;
        more.threads = 3;
        const auto again = segment_image(phantom.image, options, more);
        ASSERT_TRUE(again.ok());
        EXPECT_EQ(again.value().labels.voxels, result.value().labels.voxels) << static_cast<int>(method);
    }
}

TEST(Segment, otsu_threshold_lies_between_the_two_values) {
    const Phantom phantom(8);
    RunContext context;
    const auto result = segment_image(phantom.image, with(SegmentMethod::otsu, phantom), context);
    ASSERT_TRUE(result.ok());
    EXPECT_NEAR(result.value().low.value(), 60, 10);
}

TEST(Segment, growing_stays_in_the_piece_of_the_seed) {
    Phantom phantom(0, 8);
    for (std::size_t n = 0; n < 40; ++n) phantom.image.voxels[n] = 100;  // another piece
    RunContext context;
    SegmentOptions options = with(SegmentMethod::grow, phantom);
    options.low = 60;
    EXPECT_EQ(phantom.dice(segment_image(phantom.image, options, context).value().labels), 1);
    options.seeds.push_back({3, 0, 0});
    EXPECT_LT(phantom.dice(segment_image(phantom.image, options, context).value().labels), 1);
}

TEST(Segment, seeds_and_ranges_that_give_nothing_are_refused) {
    const Phantom phantom(0);
    RunContext context;
    SegmentOptions options = with(SegmentMethod::threshold, phantom);
    options.low = 200;
    const auto nothing = segment_image(phantom.image, options, context);
    EXPECT_EQ(nothing.error().code, "E-SGM-001");
    EXPECT_NE(nothing.error().message.find("20 to 100"), std::string::npos);
    options = with(SegmentMethod::grow, phantom);
    options.low = 60;
    options.seeds = {{0, 0, 0}};
    EXPECT_EQ(segment_image(phantom.image, options, context).error().code, "E-SGM-002");
    options.low = 0;
    const auto all = segment_image(phantom.image, options, context);
    ASSERT_TRUE(all.ok());
    ASSERT_EQ(context.warnings.size(), 1u);
    EXPECT_EQ(context.warnings[0].code, "W-SGM-001");
}

// The ball slice by slice from one seed in its middle, in an image with another bright thing beside it.
TEST(SegmentSlices, contour_of_one_slice_leads_to_the_next) {
    Phantom phantom(8);
    for (std::uint32_t k = 0; k < 32; ++k)
        for (std::uint32_t j = 0; j < 44; ++j)
            for (std::uint32_t i = 42; i < 48; ++i)
                phantom.image.voxels[phantom.image.geometry.index(i, j, k)] += 80;
    for (const auto& [method, least] : {std::pair{SegmentMethod::grow, 0.99},
                                        {SegmentMethod::confidence, 0.9},
                                        {SegmentMethod::region, 0.9},

                                        {SegmentMethod::chan_vese, 0.95}}) {
        RunContext context;
        SegmentOptions options = with(method, phantom);
        options.low = 60;
        options.iterations = 200;
        const auto result = segment_slices(phantom.image, options, {}, context);
        ASSERT_TRUE(result.ok()) << static_cast<int>(method) << to_line(result.error());
        EXPECT_GE(phantom.dice(result.value().labels), least) << static_cast<int>(method);
    }
}

TEST(SegmentSlices, a_leak_is_not_followed) {
    Phantom phantom(0);
    // From slice 20 on all is as bright as the ball.
    for (std::size_t n = phantom.image.geometry.index(0, 0, 20); n < phantom.image.voxels.size(); ++n)
        phantom.image.voxels[n] = 100;
    RunContext context;
    SegmentOptions options = with(SegmentMethod::grow, phantom);
    options.low = 60;
    const auto result = segment_slices(phantom.image, options, {}, context);
    ASSERT_TRUE(result.ok());
    ASSERT_EQ(context.warnings.size(), 1u);
    EXPECT_EQ(context.warnings[0].code, "W-SGM-003");
    EXPECT_EQ(context.warnings[0].place.slice, "slice 20");
    for (std::size_t n = phantom.image.geometry.index(0, 0, 20); n < phantom.truth.size(); ++n)
        ASSERT_EQ(result.value().labels.voxels[n], 0);
    for (std::size_t n = 0; n < phantom.image.geometry.index(0, 0, 20); ++n)
        ASSERT_EQ(result.value().labels.voxels[n], phantom.truth[n]);
}

TEST(SegmentSlices, two_seeded_slices_share_what_lies_between_and_order_is_as_given) {
    const Phantom phantom(4);
    RunContext context;
    SegmentOptions options = with(SegmentMethod::grow, phantom);
    options.low = 60;
    options.seeds = {{24, 22, 12}, {24, 22, 20}};
    SliceOptions backwards;
    for (std::uint32_t k = 32; k-- > 0;) backwards.order.push_back(k);
    const auto forth = segment_slices(phantom.image, options, {}, context);
    const auto back = segment_slices(phantom.image, options, backwards, context);
    ASSERT_TRUE(forth.ok() && back.ok());
    EXPECT_GE(phantom.dice(forth.value().labels), 0.99);
    EXPECT_EQ(forth.value().labels.voxels, back.value().labels.voxels);
}

TEST(SegmentSlices, speckle_is_taken_and_edges_stay) {
    Phantom phantom(30);
    const auto deviation = [&] {
        double squares = 0;
        for (std::size_t n = 0; n < phantom.truth.size(); ++n) {
            const double d = phantom.image.voxels[n] - (phantom.truth[n] ? 100 : 20);
            squares += d * d;
        }
        return std::sqrt(squares / static_cast<double>(phantom.truth.size()));
    };
    const double before = deviation();
    RunContext context;
    ASSERT_TRUE(reduce_speckle(phantom.image, 2, context).ok());
    EXPECT_LT(deviation(), before / 2);
}

TEST(Segment, chan_vese_grows_from_a_small_seed_in_a_large_region) {
    for (const double noise : {0.0, 20.0}) {
        const Phantom phantom(noise, 18);
        RunContext context;
        SegmentOptions options = with(SegmentMethod::chan_vese, phantom);
        options.seed_radius_mm = 3;
        const auto result = segment_image(phantom.image, options, context);
        ASSERT_TRUE(result.ok());
        EXPECT_GE(phantom.dice(result.value().labels), 0.95) << noise;
    }
}

TEST(Segment, chan_vese_ends_half_way_between_the_means) {
    Phantom phantom(0, 9);
    RunContext context;
    SegmentOptions options = with(SegmentMethod::chan_vese, phantom);
    options.curvature = 0;
    const auto sharp = segment_image(phantom.image, options, context);
    ASSERT_TRUE(sharp.ok());
    EXPECT_GE(phantom.dice(sharp.value().labels), 0.99);
    EXPECT_TRUE(context.warnings.empty());  // it came to rest
    EXPECT_NEAR(sharp.value().low.value(), 60, 12);
}

TEST(Segment, images_of_few_slices_are_no_trouble) {
    const Phantom phantom(4);
    for (const std::uint32_t slices : {1u, 2u, 3u}) {
        Phantom thin = phantom;
        const auto first = static_cast<std::ptrdiff_t>(phantom.image.geometry.index(0, 0, 16));
        const auto count = static_cast<std::ptrdiff_t>(slices * 48 * 44);
        thin.image.geometry.size[2] = slices;
        thin.image.voxels.assign(phantom.image.voxels.begin() + first,
                                 phantom.image.voxels.begin() + first + count);
        thin.truth.assign(phantom.truth.begin() + first, phantom.truth.begin() + first + count);
        thin.centre[2] = 0;
        for (const auto method : {SegmentMethod::region, SegmentMethod::geodesic, SegmentMethod::chan_vese}) {
            RunContext context;
            const auto result = segment_image(thin.image, with(method, thin), context);
            if (slices > 1 && method != SegmentMethod::chan_vese) {
                EXPECT_EQ(result.ok() ? "" : result.error().code, "E-SGM-011");
                continue;
            }
            ASSERT_TRUE(result.ok()) << to_line(result.error());
            EXPECT_GE(thin.dice(result.value().labels), 0.88) << slices << " " << static_cast<int>(method);
        }
    }
}

TEST(Segment, few_iterations_are_warned_of_and_a_cancelled_run_ends) {
    const Phantom phantom(4);
    RunContext context;
    SegmentOptions options = with(SegmentMethod::region, phantom);
    options.iterations = 2;
    const auto early = segment_image(phantom.image, options, context);
    ASSERT_TRUE(early.ok());
    EXPECT_EQ(early.value().iterations, 2u);
    ASSERT_EQ(context.warnings.size(), 1u);
    EXPECT_EQ(context.warnings[0].code, "W-SGM-002");
    const std::atomic<bool> stop = true;
    context.cancel = &stop;
    EXPECT_EQ(segment_image(phantom.image, options, context).error().kind, ErrorKind::cancelled);
}

TEST(CleanMask, grains_go_holes_are_filled_and_the_ball_stays) {
    const Phantom phantom(0);
    LabelMap labels;
    labels.geometry = phantom.image.geometry;
    labels.structures.push_back({1, "", {}});
    std::mt19937 random(9);
    std::uniform_real_distribution<double> chance(0, 1);
    for (const std::uint8_t inside : phantom.truth)
        labels.voxels.push_back(chance(random) < 0.03 ? 1 - inside : inside);
    CleanMaskOptions median;
    median.median_mm = 1.6;
    RunContext context;
    LabelMap cleaned = labels;
    ASSERT_TRUE(clean_mask(cleaned, median, context).ok());
    EXPECT_GT(phantom.dice(cleaned), 0.98);

    LabelMap holed = labels;
    holed.voxels.assign(phantom.truth.begin(), phantom.truth.end());
    for (std::uint32_t k = 14; k < 19; ++k)
        for (std::uint32_t j = 20; j < 25; ++j)
            for (std::uint32_t i = 20; i < 29; ++i) holed.voxels[holed.geometry.index(i, j, k)] = 0;
    CleanMaskOptions fill;
    fill.fill_holes = true;
    ASSERT_TRUE(clean_mask(holed, fill, context).ok());
    EXPECT_EQ(phantom.dice(holed), 1);
}

TEST(CleanMask, opening_takes_bridges_and_closing_fills_slits) {
    LabelMap two;
    two.geometry.size = {40, 20, 20};
    two.structures.push_back({1, "", {}});
    for (std::uint32_t k = 0; k < 20; ++k)
        for (std::uint32_t j = 0; j < 20; ++j)
            for (std::uint32_t i = 0; i < 40; ++i) {
                const bool block =
                    j > 4 && j < 15 && k > 4 && k < 15 && ((i > 4 && i < 16) || (i > 24 && i < 36));
                const bool bridge = j == 10 && k == 10 && i > 4 && i < 36;
                two.voxels.push_back(block || bridge);
            }
    const std::size_t middle = two.geometry.index(20, 10, 10), inner = two.geometry.index(10, 10, 10);
    RunContext context;
    LabelMap opened = two;
    CleanMaskOptions open;
    open.open_mm = 2;
    ASSERT_TRUE(clean_mask(opened, open, context).ok());
    EXPECT_EQ(opened.voxels[middle], 0);
    EXPECT_EQ(opened.voxels[inner], 1);
    LabelMap slit = two;
    for (std::uint32_t k = 0; k < 20; ++k)
        for (std::uint32_t j = 0; j < 20; ++j) slit.voxels[slit.geometry.index(10, j, k)] = 0;
    CleanMaskOptions close;
    close.close_mm = 2;
    ASSERT_TRUE(clean_mask(slit, close, context).ok());
    EXPECT_EQ(slit.voxels[inner], 1);
    open.open_mm = 9;
    EXPECT_EQ(clean_mask(two, open, context).error().code, "E-SGM-004");
}

}  // namespace
}  // namespace anatomesh::segment_test
