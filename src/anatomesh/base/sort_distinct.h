// sort_distinct: makes a list rising, and keeps each entry once.
#pragma once

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace anatomesh {

// Sorts the list, and keeps each entry once. Complexity: O(n log n).
template <class T>
void sort_distinct(std::vector<T>& list) {
    if (!std::is_sorted(list.begin(), list.end())) std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
}

// Sorts the numbers, and keeps each once. Requires: all are below `bound`. Complexity: O(n log n) where they are few
// compared with the bound; else O(n + bound / 64), with a bit for each number that there may be.
inline void sort_distinct(std::vector<std::uint32_t>& numbers, std::size_t bound) {
    // If each number costs more words than this to look through, sorting is faster. [words; > 0; B]
    constexpr std::size_t words_a_number = 32;
    assert(std::all_of(numbers.begin(), numbers.end(), [&](std::uint32_t n) { return n < bound; }));
    const std::size_t words = (bound + 63) / 64;
    if (words_a_number * numbers.size() < words) {
        sort_distinct(numbers);
        return;
    }
    std::vector<std::uint64_t> bits(words, 0);
    for (const std::uint32_t n : numbers) bits[n / 64] |= std::uint64_t{1} << (n % 64);
    std::size_t count = 0;
    for (std::size_t w = 0; w < words; ++w) {
        for (std::uint64_t left = bits[w]; left != 0; left &= left - 1) {
            numbers[count++] =
                static_cast<std::uint32_t>(64 * w) + static_cast<std::uint32_t>(std::countr_zero(left));
        }
    }
    numbers.resize(count);
}

}  // namespace anatomesh
