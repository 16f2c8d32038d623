// FailedAttemptCache: attempts on a mesh that failed and would fail again as long as nothing changes there.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "anatomesh/mesh/edit/edit_mesh.h"

namespace anatomesh {

// An attempt is named by an operation and what it is about: cells at some vertices. It is worth another one
// once one of these cells has changed. Requires: an attempt looks at these cells alone. Complexity: O(1) a
// question, and O(cells) a change.
class FailedAttemptCache {
  public:
    using Name = std::array<std::uint32_t, 4>;

    // Whether the attempt failed, and no cell at one of the vertices has changed since.
    bool contains(const Name& name, std::span<const std::uint32_t> vertices) const {
        const auto found = tried_.find(name);
        if (found == tried_.end()) return false;
        for (const std::uint32_t v : vertices) {
            if (v < changed_in_.size() && changed_in_[v] > found->second) return false;
        }
        return true;
    }

    void add(const Name& name) { tried_[name] = changes_; }

    // These cells were made, reshaped or relabelled; no_cell and cells that are gone are allowed.
    void note_change(const EditMesh& mesh, std::span<const std::uint32_t> cells) {
        ++changes_;
        changed_in_.resize(mesh.point_count(), 0);
        for (const std::uint32_t c : cells) {
            if (c == no_cell || !mesh.alive(c)) continue;
            for (const std::uint32_t v : mesh.cell(c)) changed_in_[v] = changes_;
        }
    }

  private:
    struct Hash {
        std::size_t operator()(const Name& name) const {
            std::uint64_t hash = 0;
            for (const std::uint32_t part : name) hash = (hash ^ part) * 0x9e3779b97f4a7c15u;
            return hash ^ (hash >> 32);
        }
    };

    std::uint32_t changes_ = 0;
    std::vector<std::uint32_t> changed_in_;                // by vertex: the last change of a cell there
    std::unordered_map<Name, std::uint32_t, Hash> tried_;  // after which change
};

}  // namespace anatomesh
