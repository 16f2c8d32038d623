#include "anatomesh/image/select.h"

#include <cassert>
#include <utility>

namespace anatomesh {

std::vector<std::uint64_t> count_voxels(const LabelMap& labels) {
    std::vector<std::uint64_t> counts(labels.structures.size() + 1, 0);
    for (const std::uint16_t label : labels.voxels) {
        assert(label < counts.size());
        ++counts[label];
    }
    counts.erase(counts.begin());
    return counts;
}

void select_structures(LabelMap& labels, std::span<const std::uint32_t> keep) {
    std::vector<std::uint8_t> wanted(labels.structures.size(), 0);
    for (const std::uint32_t index : keep) {
        assert(index < wanted.size());
        wanted[index] = 1;
    }
    std::vector<std::uint16_t> renamed(labels.structures.size() + 1, 0);
    std::vector<Structure> structures;
    for (std::size_t s = 0; s < wanted.size(); ++s) {
        if (!wanted[s]) continue;
        structures.push_back(std::move(labels.structures[s]));
        renamed[s + 1] = static_cast<std::uint16_t>(structures.size());
    }
    labels.structures = std::move(structures);
    for (std::uint16_t& label : labels.voxels) {
        assert(label < renamed.size());
        label = renamed[label];
    }
}

}  // namespace anatomesh
