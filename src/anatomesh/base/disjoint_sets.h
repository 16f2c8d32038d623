// DisjointSets: sets of numbers that are joined pair by pair.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace anatomesh {

// The root of a set is its smallest member, whatever the order of the joins. Union is by smaller root, with path halving
// (Tarjan and van Leeuwen, J. ACM 31, 1984).
class DisjointSets {
  public:
    explicit DisjointSets(std::size_t count) : parent_(count) {
        for (std::size_t i = 0; i < count; ++i) parent_[i] = static_cast<std::uint32_t>(i);
    }
    std::uint32_t root(std::uint32_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void join(std::uint32_t i, std::uint32_t j) {
        i = root(i);
        j = root(j);
        if (i < j) parent_[j] = i;
        if (j < i) parent_[i] = j;
    }

  private:
    std::vector<std::uint32_t> parent_;
};

}  // namespace anatomesh
