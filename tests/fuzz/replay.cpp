// fuzz_replay TARGET [ROUNDS [FOLDER...]]: gives a target its seeds, ROUNDS changed seeds, and the files of
// folders; it ends normally or the target is at fault. fuzz_replay --write TARGET FOLDER writes the seeds,
// for a fuzzer to begin with.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "targets.h"

namespace fs = std::filesystem;
using anatomesh::fuzz::Target;

namespace {

// Bytes and words that lengths, counts and numbers are made of, at their worst.
std::string changed(std::string bytes, const std::vector<std::string>& seeds, std::mt19937& random) {
    static const std::string words[] = {std::string("\xFF\xFF\xFF\xFF", 4),
                                        std::string("\0\0\0\0", 4),
                                        std::string("\xFF\xFF\xFF\x7F", 4),
                                        std::string("\0\0\0\x80", 4),
                                        "nan",
                                        "-1",
                                        "1e400",
                                        "99999999999",
                                        "\\",
                                        " ",
                                        "\n",
                                        "(",
                                        "<dict>",
                                        "{\"a\":["};
    const auto below = [&](std::size_t n) { return n == 0 ? 0 : random() % n; };
    for (std::size_t times = 1 + below(4); times > 0; --times) {
        const std::size_t at = below(bytes.size());
        switch (below(7)) {
            case 0:
                bytes.resize(at);
                break;
            case 1:
            case 2:
                if (!bytes.empty()) bytes[at] = static_cast<char>(bytes[at] ^ 1 << below(8));
                break;
            case 3: {
                const std::string& word = words[below(std::size(words))];
                bytes.replace(at, std::min(word.size(), bytes.size() - at), word);
                break;
            }
            case 4:
                bytes.insert(at, words[below(std::size(words))]);
                break;
            case 5:
                bytes.erase(at, 1 + below(16));
                break;
            default: {  // a part of another seed
                const std::string& other = seeds[below(seeds.size())];
                const std::size_t from = below(other.size());
                bytes.insert(at, other.substr(from, 1 + below(64)));
            }
        }
    }
    return bytes;
}

std::string content_of(const fs::path& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

int write_seeds(const Target& target, const fs::path& folder) {
    fs::create_directories(folder);
    int number = 0;
    for (const std::string& seed : target.seeds())
        std::ofstream(folder / ("seed" + std::to_string(number++)), std::ios::binary)
            .write(seed.data(), static_cast<std::streamsize>(seed.size()));
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    const std::vector<std::string> words(argv + 1, argv + argc);
    const bool writes = !words.empty() && words[0] == "--write";
    const std::size_t first = writes ? 1 : 0;
    const Target* target = words.size() > first ? anatomesh::fuzz::find_target(words[first]) : nullptr;
    if (!target || (writes && words.size() != 3)) {
        std::fprintf(stderr, "usage: fuzz_replay [--write] TARGET [ROUNDS] [FOLDER...]\n");
        return 2;
    }
    if (writes) return write_seeds(*target, words[2]);
    const std::vector<std::string> seeds = target->seeds();
    for (const std::string& seed : seeds) target->run(seed);
    const int rounds = words.size() > 1 ? std::atoi(words[1].c_str()) : 0;
    std::mt19937 random(1);
    for (int round = 0; round < rounds; ++round)
        target->run(changed(seeds[random() % seeds.size()], seeds, random));
    std::size_t files = 0;
    for (std::size_t w = 2; w < words.size(); ++w) {
        if (!fs::is_directory(words[w])) continue;
        for (const auto& entry : fs::recursive_directory_iterator(words[w])) {
            if (!entry.is_regular_file()) continue;
            target->run(content_of(entry.path()));
            ++files;
        }
    }
    std::printf("%zu seeds, %d changed ones, %zu files\n", seeds.size(), rounds, files);
    return 0;
}
