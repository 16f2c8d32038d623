// RegionRegistry: numbers the sets of structures that occur.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "anatomesh/mesh/tet_mesh.h"

namespace anatomesh {

// Regions are numbered in the order in which their sets are first asked for; the empty set is region 0.
class RegionRegistry {
  public:
    RegionRegistry() { numbers_.emplace(std::vector<std::uint32_t>{}, Region{0}); }

    // Requires: members sorted. Once max_regions sets are known, a further one gives region 0 and full() is true.
    Region intern(const std::vector<std::uint32_t>& members) {
        const auto known = numbers_.find(members);
        if (known != numbers_.end()) return known->second;
        if (table_.members.size() == max_regions) {
            full_ = true;
            return 0;
        }
        numbers_.emplace(members, static_cast<Region>(table_.members.size()));
        table_.members.push_back(members);
        return static_cast<Region>(table_.members.size() - 1);
    }
    // Whether a set found no number: the regions can not be trusted then.
    bool full() const { return full_; }
    const RegionTable& table() const { return table_; }

    static constexpr std::size_t max_regions = 65000;

  private:
    bool full_ = false;
    RegionTable table_;
    std::map<std::vector<std::uint32_t>, Region> numbers_;
};

}  // namespace anatomesh
