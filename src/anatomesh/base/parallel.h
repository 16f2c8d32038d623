// Parallel loops whose result does not depend on the number of threads.
#pragma once

#include <cstddef>
#include <functional>

namespace anatomesh {

// Calls body(begin, end) on consecutive pieces that together cover [0, count), at most `threads` at a time.
// Guarantees: every index once; with threads == 1 in order on the calling thread. Requires: body writes only
// to places owned by its indices. Piece boundaries depend on `count` and `grain` alone, never on `threads`.
// Follows: oneTBB parallel_for with a fixed partition.
void parallel_for(std::size_t count, std::size_t grain, int threads,
                  const std::function<void(std::size_t begin, std::size_t end)>& body);

}  // namespace anatomesh
