#include "anatomesh/base/parallel.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <mutex>
#include <set>
#include <thread>
#include <utility>
#include <vector>

namespace anatomesh::parallel_test {
namespace {

TEST(ParallelFor, every_index_once_for_any_count_grain_and_threads) {
    for (const std::size_t count : {0, 1, 2, 63, 64, 65, 1000, 12345}) {
        for (const std::size_t grain : {1, 7, 64, 100000}) {
            for (const int threads : {1, 2, 3, 16}) {
                std::vector<std::atomic<int>> visits(count);
                parallel_for(count, grain, threads, [&](std::size_t begin, std::size_t end) {
                    EXPECT_LT(begin, end);
                    for (std::size_t i = begin; i < end; ++i) ++visits[i];
                });
                for (const auto& n : visits) ASSERT_EQ(n, 1);
            }
        }
    }
}

TEST(ParallelFor, what_is_collected_keeps_its_order) {
    for (const std::size_t count : {0, 1, 100, 1003}) {
        for (const int threads : {1, 2, 5}) {
            const auto even = parallel_collect<std::size_t>(
                count, 10, threads, [](std::size_t begin, std::size_t end, std::vector<std::size_t>& out) {
                    for (std::size_t i = begin; i < end; ++i) {
                        if (i % 2 == 0) out.push_back(i);
                    }
                });
            ASSERT_EQ(even.size(), (count + 1) / 2);
            for (std::size_t i = 0; i < even.size(); ++i) EXPECT_EQ(even[i], 2 * i);
        }
    }
}

TEST(ParallelFor, pieces_depend_on_count_and_grain_alone) {
    const auto pieces = [](int threads) {
        std::mutex mutex;
        std::set<std::pair<std::size_t, std::size_t>> seen;
        parallel_for(1003, 10, threads, [&](std::size_t begin, std::size_t end) {
            const std::lock_guard lock(mutex);
            seen.emplace(begin, end);
        });
        return seen;
    };
    EXPECT_EQ(pieces(1).size(), 101u);
    EXPECT_EQ(pieces(1), pieces(2));
    EXPECT_EQ(pieces(1), pieces(5));
}

TEST(ParallelFor, one_thread_runs_in_order_on_the_caller) {
    std::size_t next = 0;
    const auto caller = std::this_thread::get_id();
    parallel_for(100, 9, 1, [&](std::size_t begin, std::size_t end) {
        EXPECT_EQ(begin, next);
        EXPECT_EQ(std::this_thread::get_id(), caller);
        next = end;
    });
    EXPECT_EQ(next, 100u);
}

TEST(ParallelFor, never_more_at_a_time_than_asked_for) {
    for (const int threads : {1, 2}) {
        std::atomic<int> now = 0, most = 0;
        parallel_for(200, 1, threads, [&](std::size_t, std::size_t) {
            const int here = ++now;
            int before = most;
            while (here > before && !most.compare_exchange_weak(before, here)) {
            }
            std::this_thread::sleep_for(std::chrono::microseconds(50));
            --now;
        });
        EXPECT_LE(most, threads);
    }
}

TEST(ParallelTasks, each_runs_once_also_with_loops_inside) {
    for (const int threads : {1, 2, 3}) {
        std::array<std::atomic<int>, 3> runs{};
        const auto loop = [&](std::size_t task) {
            parallel_for(1000, 7, threads, [&, task](std::size_t begin, std::size_t end) {
                runs[task] += static_cast<int>(end - begin);
            });
        };
        parallel_tasks(threads, {[&] { loop(0); }, [&] { loop(1); }, [&] { loop(2); }});
        for (const std::atomic<int>& count : runs) EXPECT_EQ(count, 1000);
    }
}

TEST(ParallelTasks, who_has_ended_one_helps_with_the_loops_in_another) {
    if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "one core";
    std::atomic<bool> other_runs = false;
    std::mutex mutex;
    std::set<std::thread::id> helpers;
    const auto wait_for = [](const auto& condition) {
        const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(5);
        while (!condition() && std::chrono::steady_clock::now() < end) std::this_thread::yield();
    };
    const auto two_help = [&] {
        const std::lock_guard lock(mutex);
        helpers.insert(std::this_thread::get_id());
        return helpers.size() == 2;
    };
    parallel_tasks(2, {[&] { wait_for([&] { return other_runs.load(); }); },
                       [&] {
                           other_runs = true;
                           parallel_for(2, 1, 2, [&](std::size_t, std::size_t) { wait_for(two_help); });
                       }});
    EXPECT_EQ(helpers.size(), 2u);
}

TEST(ParallelTasks, never_more_at_a_time_than_asked_for_with_the_loops_inside) {
    for (const int threads : {1, 2}) {
        std::atomic<int> now = 0, most = 0;
        const auto loop = [&] {
            parallel_for(100, 1, threads, [&](std::size_t, std::size_t) {
                const int here = ++now;
                int before = most;
                while (here > before && !most.compare_exchange_weak(before, here)) {
                }
                std::this_thread::sleep_for(std::chrono::microseconds(50));
                --now;
            });
        };
        parallel_tasks(threads, {loop, loop, loop});
        EXPECT_LE(most, threads);
    }
}

}  // namespace
}  // namespace anatomesh::parallel_test
