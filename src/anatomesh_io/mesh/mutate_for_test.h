// Damages a file in many ways, for readers that must refuse or read it but never crash.
#pragma once

#include <algorithm>
#include <cstddef>
#include <random>
#include <span>
#include <string>

namespace anatomesh {

inline std::span<const std::byte> bytes_of(const std::string& text) {
    return {reinterpret_cast<const std::byte*>(text.data()), text.size()};
}

// Calls `read` with every kind of damage: cut off, bytes flipped, digits exchanged, pieces doubled or
// removed. The damages depend on `seed` alone.
template <class Read>
void for_each_damage(const std::string& good, int rounds, unsigned seed, Read read) {
    std::mt19937 random(seed);
    const auto below = [&](std::size_t most) {
        return static_cast<std::size_t>(random() % std::max<std::size_t>(most, 1));
    };
    for (int round = 0; round < rounds; ++round) {
        std::string bad = good;
        const std::size_t at = below(bad.size()), length = 1 + below(16);
        switch (round % 6) {
            case 0:
                bad.resize(at);
                break;
            case 1:
                bad[at] = static_cast<char>(random());
                break;
            case 2:
                bad.erase(at, length);
                break;
            case 3:
                bad.insert(at, bad.substr(below(bad.size()), length));
                break;
            case 4:
                for (std::size_t i = 0; i < length; ++i)
                    bad[below(bad.size())] ^= static_cast<char>(1u << random() % 8);
                break;
            case 5: {  // another number where one stands: large, negative, not finite
                constexpr const char* numbers[] = {"99999999999999999999", "-1", "nan", "1e400",
                                                   "4294967295",           "0"};
                const std::size_t digit = bad.find_first_of("0123456789", at);
                if (digit == std::string::npos) continue;
                const std::size_t end = std::min(bad.find_first_not_of("0123456789.", digit), bad.size());
                bad.replace(digit, end - digit, numbers[random() % 6]);
                break;
            }
        }
        read(bad);
    }
}

}  // namespace anatomesh
