#include "anatomesh/contour/model/find_structures.h"

#include <algorithm>

#include "anatomesh/base/number_text.h"

namespace anatomesh {

namespace {

constexpr std::size_t most_listed = 100;  // A message lists at most so many structures. [structures; > 0; B]

std::string list_of(const std::vector<Structure>& all) {
    std::string list;
    for (std::size_t i = 0; i < std::min(all.size(), most_listed); ++i) {
        if (i > 0) list += ", ";
        const std::string number = std::to_string(all[i].number);
        list += all[i].name.empty() ? number : all[i].name + " (" + number + ")";
    }
    return all.size() > most_listed ? list + ", ..." : list;
}

}  // namespace

Result<std::vector<std::uint32_t>> find_structures(const std::vector<Structure>& all,
                                                   const std::vector<std::string>& wanted,
                                                   const std::string& file) {
    std::vector<bool> taken(all.size(), wanted.empty());
    for (const std::string& text : wanted) {
        bool found = false;
        for (std::size_t i = 0; i < all.size(); ++i) {
            if (all[i].name == text) found = taken[i] = true;
        }
        const auto number = parse_integer<std::int32_t>(text);
        for (std::size_t i = 0; !found && number && i < all.size(); ++i) {
            if (all[i].number == *number) found = taken[i] = true;
        }
        if (found) continue;
        return Error{ErrorKind::usage,
                     "E-CMD-005",
                     "the input has no structure of this name or number",
                     {file, "", text, "", ""},
                     "the structures are: " + list_of(all)};
    }
    std::vector<std::uint32_t> indices;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (taken[i]) indices.push_back(static_cast<std::uint32_t>(i));
    }
    return indices;
}

Result<std::vector<std::uint32_t>> find_in_order(const std::vector<Structure>& all,
                                                 const std::vector<std::string>& wanted,
                                                 const std::string& file) {
    std::vector<std::uint32_t> order;
    for (const std::string& name : wanted) {
        ANATOMESH_TRY(const std::vector<std::uint32_t> found, find_structures(all, {name}, file));
        for (const std::uint32_t structure : found) {
            if (std::find(order.begin(), order.end(), structure) == order.end()) order.push_back(structure);
        }
    }
    return order;
}

std::string unique_text(const std::vector<Structure>& all, std::uint32_t structure) {
    const Structure& own = all[structure];
    const auto has_name = [&](const Structure& each) { return each.name == own.name; };
    return own.name.empty() || std::count_if(all.begin(), all.end(), has_name) > 1
               ? std::to_string(own.number)
               : own.name;
}

}  // namespace anatomesh
