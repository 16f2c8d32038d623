// SharedTable: values by key, in the order of the keys, that copies share until one of them changes.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace anatomesh {

// A copy costs O(1). The first set() of a copy copies the entries, O(n); further ones change them in place, until
// share() says that copies may be taken again. Requires: share() is called before a table is copied. A const table may
// be read and copied on several threads.
template <class Key, class Value>
class SharedTable {
  public:
    struct Entry {
        Key key;
        Value value;
    };

    std::span<const Entry> entries() const {
        return entries_ ? std::span<const Entry>(*entries_) : std::span<const Entry>();
    }

    // Returns the value of the key; nullptr where there is none. O(log n).
    const Value* find(const Key& key) const {
        const auto all = entries();
        const auto found = std::lower_bound(all.begin(), all.end(), key, less);
        return found == all.end() || key < found->key ? nullptr : &found->value;
    }

    // O(n) where the key is new, or the first since share(); else O(log n).
    void set(const Key& key, Value value) {
        std::vector<Entry>& all = owned();
        const auto found = std::lower_bound(all.begin(), all.end(), key, less);
        if (found == all.end() || key < found->key)
            all.insert(found, {key, std::move(value)});
        else
            found->value = std::move(value);
    }

    // Nothing happens where the key has no value. O(n).
    void erase(const Key& key) {
        std::vector<Entry>& all = owned();
        const auto found = std::lower_bound(all.begin(), all.end(), key, less);
        if (found != all.end() && !(key < found->key)) all.erase(found);
    }

    void share() { is_owned_ = false; }

  private:
    static bool less(const Entry& entry, const Key& key) { return entry.key < key; }

    std::vector<Entry>& owned() {
        if (!is_owned_) {
            entries_ = entries_ ? std::make_shared<std::vector<Entry>>(*entries_)
                                : std::make_shared<std::vector<Entry>>();
            is_owned_ = true;
        }
        return *entries_;
    }

    std::shared_ptr<std::vector<Entry>> entries_;  // null: none
    bool is_owned_ = false;                        // no other table has these entries
};

}  // namespace anatomesh
