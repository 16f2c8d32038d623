#include "anatomesh/base/parallel.h"

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cassert>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "anatomesh/base/standard_arithmetic.h"

namespace anatomesh {

namespace {

thread_local bool in_piece = false;  // of a loop that runs on several threads

class InPiece {
  public:
    InPiece() : before_(std::exchange(in_piece, true)) {}
    ~InPiece() { in_piece = before_; }
    InPiece(const InPiece&) = delete;
    InPiece& operator=(const InPiece&) = delete;

  private:
    bool before_;
    StandardArithmetic arithmetic_;
};

// How many threads there can be at once, this one included, of the number wanted: a system may allow fewer.
int creatable_threads(int wanted) {
    std::mutex mutex;
    std::condition_variable done;
    bool all_made = false;
    std::vector<std::thread> made;
    made.reserve(static_cast<std::size_t>(wanted));
    try {
        while (static_cast<int>(made.size()) + 1 < wanted) {
            made.emplace_back([&] {
                std::unique_lock lock(mutex);
                done.wait(lock, [&] { return all_made; });
            });
        }
    } catch (const std::system_error&) {  // no more of them
    }
    {
        const std::lock_guard lock(mutex);
        all_made = true;
    }
    done.notify_all();
    for (std::thread& thread : made) thread.join();
    return static_cast<int>(made.size()) + 1;
}

// The threads that TBB uses. It ends the program where it can make none in the midst of a loop, so they are made once,
// beforehand, by loops in which nothing is lost.
class Workers {
  public:
    static int most() {
        static const Workers workers;
        return workers.most_;
    }

  private:
    Workers() : most_(creatable_threads(tbb::info::default_concurrency())) {
        if (most_ == 1) return;
        limit_.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(most_));
        try {
            tbb::parallel_for(
                0, most_, [](int) {}, tbb::simple_partitioner());
        } catch (const std::exception&) {
            most_ = 1;
        }
    }

    int most_;
    std::optional<tbb::global_control> limit_;
};

// What a thread does that waits for the others' last pieces.
enum class Waiting { helps_this_loop, helps_all };

void run_pieces(std::size_t count, std::size_t grain, int threads, Waiting waiting,
                const std::function<void(std::size_t, std::size_t)>& body) {
    assert(grain > 0 && threads > 0);
    const std::size_t pieces = (count + grain - 1) / grain;
    const auto run = [&](std::size_t piece) { body(piece * grain, std::min(count, (piece + 1) * grain)); };
    // Asked for more than the machine has, TBB would print a warning.
    const int most = threads == 1 || pieces <= 1 ? 1 : std::min(threads, Workers::most());
    if (most == 1) {
        for (std::size_t piece = 0; piece < pieces; ++piece) run(piece);
        return;
    }
    const auto run_inside = [&](std::size_t piece) {
        const InPiece inside;
        run(piece);
    };
    const auto loop = [&] {
        tbb::parallel_for(std::size_t{0}, pieces, run_inside, tbb::simple_partitioner());
    };
    if (tbb::this_task_arena::max_concurrency() != most) {
        tbb::task_arena(most).execute(loop);
    } else if (waiting == Waiting::helps_all && !in_piece) {
        loop();  // nothing but these pieces and the loops inside them is there to be helped with
    } else {
        // On all cores, or in a task, no arena is made, because it costs as much as a short loop. Threads that have
        // nothing left to do outside help. Those at work here take nothing from outside while they wait.
        tbb::this_task_arena::isolate(loop);
    }
}

}  // namespace

void parallel_for(std::size_t count, std::size_t grain, int threads,
                  const std::function<void(std::size_t, std::size_t)>& body) {
    run_pieces(count, grain, threads, Waiting::helps_this_loop, body);
}

void parallel_tasks(int threads, std::initializer_list<std::function<void()>> tasks) {
    run_pieces(tasks.size(), 1, threads, Waiting::helps_all, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) tasks.begin()[n]();
    });
}

}  // namespace anatomesh
