// Parallel loops whose result does not depend on the number of threads.
#pragma once

#include <cstddef>
#include <functional>
#include <initializer_list>
#include <vector>

namespace anatomesh {

// Calls body(begin, end) on consecutive pieces that together cover [0, count), at most `threads` at a time. Guarantees:
// every index is covered once; with threads == 1 the pieces run in order on the calling thread. Piece boundaries depend
// on `count` and `grain` alone, never on `threads`. Each piece has standard arithmetic (standard_arithmetic.h). Where the
// system allows fewer threads, fewer are used; one does the work where it allows no other. Requires: body writes only to places owned by its indices. It is
// oneTBB's parallel_for with a fixed partition.
void parallel_for(std::size_t count, std::size_t grain, int threads,
                  const std::function<void(std::size_t begin, std::size_t end)>& body);

// Runs the tasks, at most `threads` at a time. Loops inside them may take that many threads each, because threads that
// have ended their tasks help there. Requires: no task writes what another one reads or writes.
void parallel_tasks(int threads, std::initializer_list<std::function<void()>> tasks);

// Calls body(begin, end, out) as parallel_for does, with an empty `out` for each piece. Returns what the pieces put
// there, one after the other, which is the same for any number of threads.
template <class T, class Body>
std::vector<T> parallel_collect(std::size_t count, std::size_t grain, int threads, const Body& body) {
    std::vector<std::vector<T>> parts((count + grain - 1) / grain);
    parallel_for(count, grain, threads,
                 [&](std::size_t begin, std::size_t end) { body(begin, end, parts[begin / grain]); });
    std::size_t size = 0;
    for (const std::vector<T>& part : parts) size += part.size();
    std::vector<T> all;
    all.reserve(size);
    for (const std::vector<T>& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

}  // namespace anatomesh
