// RegionRegistry: numbers the sets of structures that occur.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

// Regions are numbered in the order in which their sets are first asked for; the empty set is region 0.
class RegionRegistry {
  public:
    // `exclusive`: no set that with_other_side() asks for has more than one structure.
    RegionRegistry() : RegionRegistry(false) {}
    explicit RegionRegistry(bool exclusive) : exclusive_(exclusive) {
        numbers_.emplace(std::vector<std::uint32_t>{}, Region{0});
    }

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
    // The region with the structure taken away, or added: where structures exclude each other it takes the
    // place of the one that was there.
    Region with_other_side(Region region, std::uint32_t structure) {
        std::vector<std::uint32_t> members = table_.members[region];
        const auto place = std::lower_bound(members.begin(), members.end(), structure);
        if (place != members.end() && *place == structure) {
            members.erase(place);
        } else if (exclusive_) {
            members = {structure};
        } else {
            members.insert(place, structure);
        }
        return intern(members);
    }
    // Whether a set found no number: the regions can not be trusted then.
    bool full() const { return full_; }
    const RegionTable& table() const { return table_; }

    // More sets of structures are refused: a region is a number of 16 bits, and some are left for the stages.
    // [regions; 1 to 65535; B]
    static constexpr std::size_t max_regions = 65000;

  private:
    bool exclusive_;
    bool full_ = false;
    RegionTable table_;
    std::map<std::vector<std::uint32_t>, Region> numbers_;
};

}  // namespace anatomesh
