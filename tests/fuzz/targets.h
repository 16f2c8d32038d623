// What is fuzzed: readers of files from outside, each given bytes that may be anything. A reader must return,
// within limits of memory, and what it accepts must make sense.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace anatomesh::fuzz {

struct Target {
    const char* name;
    void (*run)(std::string_view bytes);  // aborts when a promise is broken
    std::vector<std::string> (*seeds)();  // whole files, good and wrong
};

std::span<const Target> targets();
const Target* find_target(std::string_view name);

}  // namespace anatomesh::fuzz
