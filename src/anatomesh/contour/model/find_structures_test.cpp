#include "anatomesh/contour/model/find_structures.h"

#include <gtest/gtest.h>

namespace anatomesh::find_structures_test {
namespace {

using Indices = std::vector<std::uint32_t>;

// "7" is a name here, and a number there.
const std::vector<Structure> all{
    {3, "liver", {}}, {7, "spleen", {}}, {5, "7", {}}, {8, "liver", {}}, {9, "", {}}};

Indices found(const std::vector<std::string>& wanted) {
    const auto result = find_structures(all, wanted, "a.json");
    EXPECT_TRUE(result.ok());
    return result.ok() ? result.value() : Indices{};
}

TEST(FindStructures, by_name_first_then_by_number) {
    EXPECT_EQ(found({}), (Indices{0, 1, 2, 3, 4}));
    EXPECT_EQ(found({"spleen"}), Indices{1});
    EXPECT_EQ(found({"7"}), Indices{2}) << "the name comes first";
    EXPECT_EQ(found({"5"}), Indices{2});
    EXPECT_EQ(found({"liver"}), (Indices{0, 3})) << "all of the name";
    EXPECT_EQ(found({"9", "3"}), (Indices{0, 4})) << "ascending";
    EXPECT_EQ(found({"+9"}), Indices{4});
}

TEST(FindStructures, in_order_each_once) {
    const auto order = find_in_order(all, {"9", "liver", "3", "spleen"}, "a.json");
    ASSERT_TRUE(order.ok());
    EXPECT_EQ(order.value(), (Indices{4, 0, 3, 1}));
    EXPECT_TRUE(find_in_order(all, {}, "a.json").value().empty());
}

TEST(FindStructures, says_what_there_is) {
    const auto result = find_structures(all, {"spleen", "kidney"}, "a.json");
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(to_line(result.error()),
              "E-CMD-005 a.json, structure kidney: the input has no structure of this name or number "
              "(next: the structures are: liver (3), spleen (7), 7 (5), liver (8), 9)");
    std::vector<Structure> many(150);
    for (std::size_t s = 0; s < many.size(); ++s) many[s].number = static_cast<std::int32_t>(s + 1);
    const auto none = find_structures(many, {"x"}, "a.json");
    ASSERT_FALSE(none.ok());
    EXPECT_TRUE(none.error().next_step.ends_with(", 99, 100, ...")) << none.error().next_step;
}

TEST(FindStructures, a_unique_text_finds_its_structure_alone) {
    EXPECT_EQ(unique_text(all, 0), "3");
    EXPECT_EQ(unique_text(all, 1), "spleen");
    EXPECT_EQ(unique_text(all, 4), "9");
}

}  // namespace
}  // namespace anatomesh::find_structures_test
