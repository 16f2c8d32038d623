#include "anatomesh/field/stack/earlier_maps.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

namespace anatomesh {

std::uint64_t fingerprint_of(std::span<const Edge2> edges) {
    std::uint64_t sum = edges.size();
    // The finalizer of splitmix64 (Steele, Lea and Flood, OOPSLA 2014).
    const auto add = [&](double value) {
        sum += std::bit_cast<std::uint64_t>(value) + 0x9E3779B97F4A7C15ull;
        sum = (sum ^ (sum >> 30)) * 0xBF58476D1CE4E5B9ull;
        sum = (sum ^ (sum >> 27)) * 0x94D049BB133111EBull;
        sum ^= sum >> 31;
    };
    // An edge ends where the next one begins, but for the last of a contour.
    for (const Edge2& edge : edges) {
        add(edge.a.x);
        add(edge.a.y);
    }
    return sum;
}

bool have_equal_bits(std::span<const Edge2> a, std::span<const Edge2> b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

EarlierMaps::EarlierMaps(std::vector<Entry> entries) : entries_(std::move(entries)) {
    std::stable_sort(entries_.begin(), entries_.end(),
                     [](const Entry& e, const Entry& f) { return e.fingerprint < f.fingerprint; });
}

const EarlierMaps::Entry* EarlierMaps::find(std::uint64_t fingerprint, std::span<const Edge2> edges,
                                            double limit) const {
    const auto before = [](const Entry& entry, std::uint64_t value) { return entry.fingerprint < value; };
    for (auto entry = std::lower_bound(entries_.begin(), entries_.end(), fingerprint, before);
         entry != entries_.end() && entry->fingerprint == fingerprint; ++entry) {
        if (entry->map->limit() == limit && have_equal_bits(entry->map->edges(), edges)) return &*entry;
    }
    return nullptr;
}

}  // namespace anatomesh
