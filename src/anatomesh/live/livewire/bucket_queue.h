// BucketQueue: pixels by integer labels that differ by less than the number of buckets; the least comes out first.
#pragma once

#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace anatomesh {

// A circular array of doubly linked lists, one for each label, and a bit for each list that is not empty. Of equal labels
// the one that was put in last comes first. Memory: 8 bytes for each pixel and 4 for each bucket.
// Source: Dial, Communications of the ACM 12, 1969.
class BucketQueue {
  public:
    // Requires: `buckets` is a power of two and >= 64.
    BucketQueue(std::size_t pixels, std::uint32_t buckets)
        : mask_(buckets - 1), first_(buckets, none), occupied_(buckets / 64, 0), links_(pixels) {
        assert(std::has_single_bit(buckets) && buckets >= 64);
    }

    bool contains(std::uint32_t pixel) const { return links_[pixel].previous != absent; }
    bool empty() const { return size_ == 0; }

    // O(1). Requires: the pixel is not in the queue; all labels lie within [label of the last pop, that + buckets).
    void push(std::uint32_t pixel, std::uint32_t label) {
        assert(!contains(pixel));
        const std::uint32_t bucket = label & mask_, next = first_[bucket];
        links_[pixel] = {none, next};
        if (next != none) links_[next].previous = pixel;
        first_[bucket] = pixel;
        occupied_[bucket / 64] |= std::uint64_t{1} << (bucket % 64);
        ++size_;
    }

    // O(1). Requires: the pixel is in the queue, with this label.
    void remove(std::uint32_t pixel, std::uint32_t label) {
        assert(contains(pixel));
        const auto [previous, next] = links_[pixel];
        if (next != none) links_[next].previous = previous;
        if (previous != none) {
            links_[previous].next = next;
        } else {
            const std::uint32_t bucket = label & mask_;
            first_[bucket] = next;
            if (next == none) occupied_[bucket / 64] &= ~(std::uint64_t{1} << (bucket % 64));
        }
        links_[pixel].previous = absent;
        --size_;
    }

    // Removes a pixel of the least label, and returns it. `label` is at most the least label, and becomes it.
    // O(buckets / 64). Requires: the queue is not empty.
    std::uint32_t pop(std::uint32_t& label) {
        assert(!empty());
        const std::uint32_t start = label & mask_;
        std::uint32_t word = start / 64;
        std::uint64_t bits = occupied_[word] & (~std::uint64_t{0} << (start % 64));
        while (bits == 0) {
            word = word + 1 == occupied_.size() ? 0 : word + 1;
            bits = occupied_[word];
        }
        const std::uint32_t bucket = 64 * word + static_cast<std::uint32_t>(std::countr_zero(bits));
        label += (bucket - start) & mask_;
        const std::uint32_t pixel = first_[bucket];
        remove(pixel, label);
        return pixel;
    }

    // Takes all pixels out. O(pixels in the queue + buckets / 64).
    void clear() {
        for (std::size_t word = 0; word < occupied_.size(); ++word) {
            for (; occupied_[word] != 0; occupied_[word] &= occupied_[word] - 1) {
                const std::size_t bucket =
                    64 * word + static_cast<std::size_t>(std::countr_zero(occupied_[word]));
                for (std::uint32_t pixel = first_[bucket]; pixel != none; pixel = links_[pixel].next) {
                    links_[pixel].previous = absent;
                }
                first_[bucket] = none;
            }
        }
        size_ = 0;
    }

  private:
    static constexpr std::uint32_t none =
        0xFFFFFFFF;  // no pixel follows, or goes before [index; one value; D]
    static constexpr std::uint32_t absent = 0xFFFFFFFE;  // the pixel is in no list [index; one value; D]
    struct Links {
        std::uint32_t previous = absent, next = none;
    };

    std::uint32_t mask_;
    std::vector<std::uint32_t> first_;
    std::vector<std::uint64_t> occupied_;
    std::vector<Links> links_;
    std::size_t size_ = 0;
};

}  // namespace anatomesh
