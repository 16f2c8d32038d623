// RegionRegistry: numbers the sets of structures that occur.
#pragma once

#include <cassert>
#include <cstdint>
#include <map>
#include <vector>

#include "anatomesh/mesh/tet_mesh.h"

namespace anatomesh {

// Regions are numbered in the order in which their sets are first asked for; the empty set is region 0.
class RegionRegistry {
  public:
    RegionRegistry() { numbers_.emplace(std::vector<std::uint32_t>{}, Region{0}); }

    // Requires: members sorted; fewer than 65,536 different sets.
    Region intern(const std::vector<std::uint32_t>& members) {
        const auto [place, added] = numbers_.try_emplace(members, static_cast<Region>(table_.members.size()));
        if (added) {
            assert(table_.members.size() < 0xFFFF);
            table_.members.push_back(members);
        }
        return place->second;
    }
    const RegionTable& table() const { return table_; }

  private:
    RegionTable table_;
    std::map<std::vector<std::uint32_t>, Region> numbers_;
};

}  // namespace anatomesh
