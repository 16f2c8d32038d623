#include "anatomesh/base/parallel.h"

#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cassert>

namespace anatomesh {

void parallel_for(std::size_t count, std::size_t grain, int threads,
                  const std::function<void(std::size_t, std::size_t)>& body) {
    assert(grain > 0 && threads > 0);
    const std::size_t pieces = (count + grain - 1) / grain;
    const auto run = [&](std::size_t piece) { body(piece * grain, std::min(count, (piece + 1) * grain)); };
    if (threads == 1 || pieces <= 1) {
        for (std::size_t piece = 0; piece < pieces; ++piece) run(piece);
        return;
    }
    // Asked for more than the machine has, TBB would print a warning.
    const int most = std::min(threads, tbb::info::default_concurrency());
    const auto loop = [&] { tbb::parallel_for(std::size_t{0}, pieces, run, tbb::simple_partitioner()); };
    if (tbb::this_task_arena::max_concurrency() == most) {
        // On all cores, or in a task: no arena is made, which costs as much as a short loop, and threads that
        // have nothing left to do outside help; those at work here take nothing from outside while they wait.
        tbb::this_task_arena::isolate(loop);
    } else {
        tbb::task_arena(most).execute(loop);
    }
}

void parallel_tasks(int threads, std::initializer_list<std::function<void()>> tasks) {
    parallel_for(tasks.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) tasks.begin()[n]();
    });
}

}  // namespace anatomesh
