#include "anatomesh/live/livewire/shortest_paths.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "anatomesh/live/livewire/livewire_pictures_for_test.h"

namespace anatomesh::shortest_paths_test {
namespace {

using testing::random_costs;

constexpr std::uint32_t unreached = ShortestPaths::unreached;

PixelWindow whole(const PictureGrid& grid) {
    return {0, 0, grid.size[0], grid.size[1]};
}

std::uint32_t between(std::uint32_t low, std::uint32_t high, std::mt19937& random) {
    return low + static_cast<std::uint32_t>(random() % (high - low));
}

PixelWindow random_window(const PictureGrid& grid, std::mt19937& random) {
    PixelWindow window;
    window.left = between(0, grid.size[0], random);
    window.top = between(0, grid.size[1], random);
    window.right = between(window.left + 1, grid.size[0] + 1, random);
    window.bottom = between(window.top + 1, grid.size[1] + 1, random);
    return window;
}

std::uint32_t random_pixel(const PictureGrid& grid, const PixelWindow& window, std::mt19937& random) {
    return grid.index(
        {between(window.left, window.right, random), between(window.top, window.bottom, random)});
}

// The cost of the step between two neighbours, or 0 if they are none.
std::uint32_t step_between(const LivewireCosts& costs, std::uint32_t a, std::uint32_t b) {
    if (a > b) std::swap(a, b);
    const Pixel p = costs.grid.pixel(a), q = costs.grid.pixel(b);
    const int i = int(q.i) - int(p.i), j = int(q.j) - int(p.j);
    const int direction = j == 0 && i == 1    ? 0
                          : j == 1 && i == 0  ? 1
                          : j == 1 && i == 1  ? 2
                          : j == 1 && i == -1 ? 3
                                              : -1;
    return direction < 0 ? 0 : costs.steps[step_directions * a + std::size_t(direction)];
}

// Bellman and Ford: lowers the costs of all pixels along all steps until none changes.
std::vector<std::uint32_t> by_force(const LivewireCosts& costs, std::uint32_t source,
                                    const PixelWindow& window) {
    const PictureGrid& grid = costs.grid;
    std::vector<std::uint32_t> cost(grid.count(), unreached);
    cost[source] = 0;
    for (bool changed = true; changed;) {
        changed = false;
        for (std::uint32_t v = 0; v < grid.count(); ++v) {
            if (cost[v] == unreached) continue;
            for (int n = 0; n < 9; ++n) {
                const int i = int(grid.pixel(v).i) + n % 3 - 1, j = int(grid.pixel(v).j) + n / 3 - 1;
                if (n == 4 || i < int(window.left) || i >= int(window.right) || j < int(window.top) ||
                    j >= int(window.bottom))
                    continue;
                const std::uint32_t w = grid.index({std::uint32_t(i), std::uint32_t(j)});
                const std::uint32_t through = cost[v] + step_between(costs, v, w);
                if (through >= cost[w]) continue;
                cost[w] = through;
                changed = true;
            }
        }
    }
    return cost;
}

std::uint32_t cost_along(const LivewireCosts& costs, const std::vector<std::uint32_t>& path) {
    std::uint32_t sum = 0;
    for (std::size_t n = 1; n < path.size(); ++n) {
        const std::uint32_t step = step_between(costs, path[n - 1], path[n]);
        EXPECT_GT(step, 0u);  // else they are no neighbours
        sum += step;
    }
    return sum;
}

// Pictures of all forms, costs of few values (many ties) and of many.
template <class Check>
void for_random_pictures(int count, const Check& check) {
    std::mt19937 random(3);
    for (int n = 0; n < count; ++n) {
        PictureGrid grid{{between(1, 24, random), between(1, 24, random)}, {0.5, 1.5}};
        if (n % 10 == 0) grid.size[n / 10 % 2] = 1;
        const std::uint32_t most = n % 3 == 0 ? 2 : n % 3 == 1 ? 30 : most_step_cost;
        check(random_costs(grid, most, random), random);
    }
}

TEST(ShortestPaths, cost_what_bellman_and_ford_find_in_any_window) {
    for_random_pictures(300, [](const LivewireCosts& costs, std::mt19937& random) {
        const PixelWindow window = random_window(costs.grid, random);
        const std::uint32_t source = random_pixel(costs.grid, window, random);
        const std::vector<std::uint32_t> expected = by_force(costs, source, window);
        ShortestPaths paths(costs);
        paths.start(source, window);
        for (int query = 0; query < 12; ++query) {
            const std::uint32_t pixel = random_pixel(costs.grid, window, random);
            ASSERT_EQ(paths.settle(pixel), expected[pixel]);
            const std::vector<std::uint32_t> path = paths.path(pixel);
            ASSERT_EQ(path.front(), source);
            ASSERT_EQ(path.back(), pixel);
            ASSERT_EQ(cost_along(costs, path), expected[pixel]);
        }
    });
}

TEST(ShortestPaths, cost_the_same_in_both_directions) {
    for_random_pictures(200, [](const LivewireCosts& costs, std::mt19937& random) {
        const PixelWindow window = whole(costs.grid);
        const std::uint32_t a = random_pixel(costs.grid, window, random),
                            b = random_pixel(costs.grid, window, random);
        ShortestPaths forward(costs), back(costs);
        forward.start(a, window);
        back.start(b, window);
        ASSERT_EQ(forward.settle(b), back.settle(a));
    });
}

// Settled once and for all where the cost says so, and always what a search of that window alone finds.
TEST(ShortestPaths, a_window_that_grows_gives_the_paths_of_a_new_search) {
    int kept = 0, open = 0;
    for_random_pictures(300, [&](const LivewireCosts& costs, std::mt19937& random) {
        const PictureGrid& grid = costs.grid;
        PixelWindow window = random_window(grid, random);
        const std::uint32_t source = random_pixel(grid, window, random);
        ShortestPaths growing(costs), all(costs);
        growing.start(source, window);
        all.start(source, whole(grid));
        for (int round = 0; round < 5; ++round) {
            ShortestPaths anew(costs);
            anew.start(source, window);
            for (int query = 0; query < 4; ++query) {
                const std::uint32_t pixel = random_pixel(grid, window, random);
                ASSERT_EQ(growing.settle(pixel), anew.settle(pixel));
                ASSERT_EQ(growing.path(pixel), anew.path(pixel));
                all.settle(pixel);
                ASSERT_GE(growing.cost(pixel), all.cost(pixel));
                if (growing.cost(pixel) <= growing.escape_cost()) {
                    ++kept;
                    ASSERT_EQ(growing.path(pixel), all.path(pixel));
                } else {
                    ++open;
                }
            }
            const PixelWindow other = random_window(grid, random);
            window = {std::min(window.left, other.left), std::min(window.top, other.top),
                      std::max(window.right, other.right), std::max(window.bottom, other.bottom)};
            growing.grow(window);
        }
    });
    EXPECT_GT(kept, 1000);
    EXPECT_GT(open, 300);
}

TEST(ShortestPaths, paths_do_not_depend_on_what_was_asked_before) {
    for_random_pictures(200, [](const LivewireCosts& costs, std::mt19937& random) {
        const PixelWindow window = whole(costs.grid);
        const std::uint32_t source = random_pixel(costs.grid, window, random);
        ShortestPaths busy(costs);
        busy.start(random_pixel(costs.grid, window, random), window);
        busy.settle(random_pixel(costs.grid, window, random));
        busy.start(source, window);
        for (int query = 0; query < 5; ++query) {
            const std::uint32_t pixel = random_pixel(costs.grid, window, random);
            ShortestPaths fresh(costs);
            fresh.start(source, window);
            fresh.settle(pixel);
            busy.settle(pixel);
            ASSERT_EQ(busy.path(pixel), fresh.path(pixel));
        }
    });
}

// The largest step costs everywhere, along the longest side: no label overflows.
TEST(ShortestPaths, the_largest_costs_add_up) {
    const PictureGrid grid{{most_pixels_of_side, 3}, {1, 1}};
    std::mt19937 random(1);
    LivewireCosts costs = random_costs(grid, 1, random);
    for (std::uint16_t& step : costs.steps) step = static_cast<std::uint16_t>(step * most_step_cost);
    ShortestPaths paths(costs);
    paths.start(0, whole(grid));
    const std::uint32_t end = grid.index({most_pixels_of_side - 1, 0});
    EXPECT_EQ(paths.settle(end), (most_pixels_of_side - 1) * most_step_cost);
    EXPECT_EQ(paths.path(end).size(), most_pixels_of_side);
}

TEST(BucketQueue, gives_the_least_label_first) {
    std::mt19937 random(7);
    constexpr std::uint32_t buckets = 256, pixels = 500;
    for (int n = 0; n < 200; ++n) {
        BucketQueue queue(pixels, buckets);
        std::vector<std::uint32_t> labels(pixels, 0);
        std::uint32_t label = static_cast<std::uint32_t>(random() % 10000);
        std::size_t count = 0;
        for (int turn = 0; turn < 1000; ++turn) {
            const auto pixel = static_cast<std::uint32_t>(random() % pixels);
            const unsigned what = random() % 7;
            if (what < 3 && !queue.contains(pixel)) {
                labels[pixel] = label + static_cast<std::uint32_t>(random() % buckets);
                queue.push(pixel, labels[pixel]);
                ++count;
            } else if (what == 3 && queue.contains(pixel)) {
                queue.remove(pixel, labels[pixel]);
                --count;
            } else if (what > 3 && !queue.empty()) {
                std::uint32_t least = unreached;
                for (std::uint32_t p = 0; p < pixels; ++p) {
                    if (queue.contains(p)) least = std::min(least, labels[p]);
                }
                const std::uint32_t popped = queue.pop(label);
                ASSERT_EQ(label, least);
                ASSERT_EQ(labels[popped], least);
                ASSERT_FALSE(queue.contains(popped));
                --count;
            }
            ASSERT_EQ(queue.empty(), count == 0);
        }
        queue.clear();
        ASSERT_TRUE(queue.empty());
        for (std::uint32_t p = 0; p < pixels; ++p) ASSERT_FALSE(queue.contains(p));
        queue.push(3, label + 5);
        ASSERT_EQ(queue.pop(label), 3u);
    }
}

}  // namespace
}  // namespace anatomesh::shortest_paths_test
