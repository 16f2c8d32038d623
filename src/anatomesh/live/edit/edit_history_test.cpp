#include "anatomesh/live/edit/edit_history.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "anatomesh/live/edit/drawing_for_test.h"

namespace anatomesh::edit_history_test {
namespace {

using namespace drawing_for_test;

bool undo(EditHistory& history) {
    return history.undo().value();
}
bool redo(EditHistory& history) {
    return history.redo().value();
}

// A history with so many structures and parallel planes.
EditHistory prepared(int structures, int planes) {
    EditHistory history;
    for (int s = 1; s <= structures; ++s) {
        const auto added = history.apply(add_structure(
            history.drawing(), {{s, "organ " + std::to_string(s), {1, 2, 3}}, false}, "Add a structure"));
        EXPECT_TRUE(added.ok());
    }
    for (int p = 1; p <= planes; ++p) {
        const auto added = history.apply(add_plane(
            history.drawing(), p, {make_plane({0, 0, 3.0 * p}, {0, 0, 1}), "", 3, false}, "Add a plane"));
        EXPECT_TRUE(added.ok());
    }
    return history;
}

class RandomHistories : public testing::TestWithParam<unsigned> {};

TEST_P(RandomHistories, undoing_all_gives_the_first_drawing_and_redoing_all_the_last) {
    RandomSteps steps(GetParam());
    EditHistory history(Drawing({Frame::lps, 0.7, 2.5}));
    std::vector<Drawing> noted{history.drawing()};
    const std::size_t count = 200 + GetParam() % 300;
    while (history.done().size() < count) {
        ASSERT_TRUE(history.apply(steps.step(history.drawing())).ok());
        ASSERT_FALSE(same_drawing(history.drawing(), noted.back())) << "each step changes something";
        noted.push_back(history.drawing());
    }
    for (int way = 0; way < 2; ++way) {
        for (std::size_t n = count; n-- > 0;) {
            ASSERT_TRUE(undo(history));
            ASSERT_TRUE(same_drawing(history.drawing(), noted[n])) << n;
        }
        EXPECT_FALSE(undo(history));
        for (std::size_t n = 1; n <= count; ++n) {
            ASSERT_TRUE(redo(history));
            ASSERT_TRUE(same_drawing(history.drawing(), noted[n])) << n;
        }
        EXPECT_FALSE(redo(history));
    }
    EXPECT_FALSE(same_drawing(noted.front(), noted.back()));
}

TEST_P(RandomHistories, steps_undo_and_redo_in_any_order_follow_a_list_of_drawings) {
    RandomSteps steps(GetParam());
    EditHistory history;
    std::vector<Drawing> line{
        history.drawing()};  // drawings before and after each step, as a list shows them
    std::size_t at = 0;
    for (int n = 0; n < 300; ++n) {
        const std::uint32_t move = steps.below(4);
        if (move == 0) {
            ASSERT_EQ(undo(history), at > 0);
            at -= at > 0 ? 1 : 0;
        } else if (move == 1) {
            ASSERT_EQ(redo(history), at + 1 < line.size());
            at += at + 1 < line.size() ? 1 : 0;
        } else {
            ASSERT_TRUE(history.apply(steps.step(history.drawing())).ok());
            line.resize(++at);
            line.push_back(history.drawing());
        }
        ASSERT_TRUE(same_drawing(history.drawing(), line[at]));
        ASSERT_EQ(history.done().size(), at);
        ASSERT_EQ(history.undone().size(), line.size() - 1 - at);
    }
}

TEST_P(RandomHistories, revisions_rise_with_each_change_of_a_key_and_stay_otherwise) {
    RandomSteps steps(GetParam());
    EditHistory history;
    for (int n = 0; n < 300; ++n) {
        const Drawing before = history.drawing();
        if (steps.below(3) == 0) {
            if (!(steps.below(2) == 0 ? undo(history) : redo(history))) continue;
        } else {
            ASSERT_TRUE(history.apply(steps.step(before)).ok());
        }
        const Drawing& after = history.drawing();
        ASSERT_EQ(after.revision(), before.revision() + 1);
        std::set<RingsKey> keys;
        for (const Drawing* drawing : {&before, &after}) {
            for (const auto* table : {&drawing->rings(), &drawing->proposals()}) {
                for (const auto& entry : table->entries()) keys.insert(entry.key);
            }
        }
        for (const RingsKey& key : keys) {
            const auto same = [&](const DrawingKey& each) {
                return same_value(before.value(each), after.value(each));
            };
            const bool is_same = same(DrawingKey::of_rings(key)) && same(DrawingKey::of_proposal(key)) &&
                                 same(DrawingKey::of_plane(key.plane));
            if (!is_same) {
                ASSERT_EQ(after.revision(key), after.revision());
            } else if (after.revision(key) != after.revision()) {
                ASSERT_EQ(after.revision(key), before.revision(key));
            }
        }
    }
}

TEST_P(RandomHistories, the_second_of_two_edits_of_one_key_is_refused_and_nothing_changes) {
    RandomSteps steps(GetParam());
    EditHistory history;
    for (int n = 0; n < 60; ++n) ASSERT_TRUE(history.apply(steps.step(history.drawing())).ok());
    int refused = 0;
    for (int n = 0; n < 200; ++n) {
        const Edit one = steps.step(history.drawing()), other = steps.step(history.drawing());
        std::set<DrawingKey> of_one;
        for (const Change& change : one.changes) of_one.insert(change.key);
        const bool meet = std::any_of(other.changes.begin(), other.changes.end(),
                                      [&](const Change& change) { return of_one.contains(change.key); });
        ASSERT_TRUE(history.apply(one).ok());
        const Drawing before = history.drawing();
        const std::size_t undone = history.undone().size();
        const Status second = history.apply(other);
        if (meet) {
            ASSERT_FALSE(second.ok());
            // What the first left may break what the second relies on before its own change is looked at.
            ++refused;
        }
        if (!second.ok()) {
            ASSERT_TRUE(same_drawing(history.drawing(), before));
            ASSERT_EQ(history.drawing().revision(), before.revision());
            ASSERT_EQ(history.undone().size(), undone);
        }
    }
    EXPECT_GT(refused, 5);
}

INSTANTIATE_TEST_SUITE_P(seeds, RandomHistories, testing::Range(0u, 20u));

TEST(EditHistory, three_strokes_undo_a_fourth_then_redo_does_nothing_and_two_undos_leave_one) {
    EditHistory history = prepared(1, 1);
    const std::size_t first = history.done().size();
    std::mt19937 random(1);
    const Plane& plane = history.drawing().plane(1)->plane;
    std::vector<Drawing> noted{history.drawing()};
    for (int stroke = 1; stroke <= 4; ++stroke) {
        if (stroke == 4) {
            EXPECT_TRUE(undo(history));
        }
        ASSERT_TRUE(history
                        .apply(set_rings(history.drawing(), {1, 1}, star_rings(plane, random, stroke),
                                         "Stroke " + std::to_string(stroke)))
                        .ok());
        noted.push_back(history.drawing());
    }
    EXPECT_FALSE(redo(history));
    EXPECT_EQ(history.done().back().name, "Stroke 4");
    EXPECT_TRUE(undo(history));
    EXPECT_TRUE(undo(history));
    EXPECT_TRUE(same_drawing(history.drawing(), noted[1]));
    EXPECT_EQ(history.done().size(), first + 1);
    EXPECT_EQ(history.undone().back().name, "Stroke 2");
    EXPECT_EQ(history.undone().front().name, "Stroke 4");
}

TEST(EditHistory, a_deleted_structure_comes_back_with_name_colour_place_lock_and_rings) {
    EditHistory history = prepared(3, 20);
    std::mt19937 random(2);
    for (int p = 1; p <= 20; ++p) {
        for (int s = 1; s <= 3; ++s) {
            const Plane& plane = history.drawing().plane(p)->plane;
            ASSERT_TRUE(
                history.apply(set_rings(history.drawing(), {p, s}, star_rings(plane, random), "Draw")).ok());
        }
    }
    const Drawing before = history.drawing();
    const DrawnStructure locked{{1, "Leber", {9, 8, 7}}, true};
    ASSERT_TRUE(history.apply(change_structure(before, locked, "Lock")).ok());
    const Drawing with_lock = history.drawing();
    const Status refused = history.apply(remove_structure(with_lock, 1, "Delete"));
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, "E-EDT-009");
    EXPECT_EQ(refused.error().place.structure, "Leber");

    // One step that unlocks and deletes.
    DrawnStructure unlocked = locked;
    unlocked.locked = false;
    Edit deletion = change_structure(with_lock, unlocked, "Delete for good");
    const Drawing free = applied(with_lock, deletion).value();
    for (Change& change : remove_structure(free, 1, "").changes)
        deletion.changes.push_back(std::move(change));
    ASSERT_TRUE(history.apply(deletion).ok());
    EXPECT_EQ(history.drawing().order(), (StructureOrder{2, 3}));
    EXPECT_EQ(history.drawing().rings().entries().size(), 40u);
    for (int p = 1; p <= 20; ++p) {
        for (int s = 2; s <= 3; ++s) {
            EXPECT_EQ(history.drawing().rings({p, s}), before.rings({p, s})) << "others share what they had";
            EXPECT_EQ(history.drawing().revision({p, s}), before.revision({p, s}));
        }
    }
    ASSERT_TRUE(undo(history));
    EXPECT_TRUE(same_drawing(history.drawing(), with_lock));
    EXPECT_EQ(history.drawing().structure(1)->structure.name, "Leber");
    EXPECT_TRUE(history.drawing().structure(1)->locked);
    EXPECT_EQ(history.drawing().order(), (StructureOrder{1, 2, 3}));
    ASSERT_TRUE(undo(history));
    EXPECT_TRUE(same_drawing(history.drawing(), before));
}

TEST(EditHistory, proposals_on_five_slices_are_accepted_as_one_step) {
    EditHistory history = prepared(2, 5);
    std::mt19937 random(3);
    std::vector<RingsKey> keys;
    for (int p = 1; p <= 5; ++p) {
        keys.push_back({p, 2});
        const Plane& plane = history.drawing().plane(p)->plane;
        ASSERT_TRUE(
            history.apply(set_proposal(history.drawing(), {p, 2}, star_rings(plane, random), "Propose"))
                .ok());
    }
    const Drawing before = history.drawing();
    const std::size_t steps = history.done().size();
    ASSERT_TRUE(history.apply(accept_proposals(before, keys, "Accept 5 slices")).ok());
    EXPECT_EQ(history.done().size(), steps + 1);
    EXPECT_TRUE(history.drawing().proposals().entries().empty());
    for (const RingsKey& key : keys) EXPECT_EQ(history.drawing().rings(key), before.proposal(key));
    ASSERT_TRUE(undo(history));
    EXPECT_TRUE(same_drawing(history.drawing(), before));
}

TEST(EditHistory, what_cannot_be_kept_changes_nothing) {
    EditHistory history = prepared(1, 1);
    ASSERT_TRUE(undo(history));
    const Drawing before = history.drawing();
    const EditHistory::Keep fails = [] {
        return Status(Error{ErrorKind::file, "E-FILE-008", "full", {}, ""});
    };
    const auto step = add_plane(before, 7, {make_plane({0, 0, 1}, {0, 0, 1}), "", 0, false}, "Add");
    EXPECT_EQ(history.apply(step, fails).error().code, "E-FILE-008");
    EXPECT_EQ(history.undo(fails).error().code, "E-FILE-008");
    EXPECT_EQ(history.redo(fails).error().code, "E-FILE-008");
    EXPECT_TRUE(same_drawing(history.drawing(), before));
    EXPECT_EQ(history.undone().size(), 1u);
    bool asked = false;
    const EditHistory::Keep notes = [&] {
        asked = true;
        return Status(Nothing{});
    };
    EXPECT_FALSE(history.apply({"nothing", {}}, notes).ok());
    EXPECT_FALSE(asked) << "what is refused is not written";
    EXPECT_TRUE(history.redo(notes).value());
    EXPECT_TRUE(asked);
    asked = false;
    EXPECT_FALSE(history.redo(notes).value());
    EXPECT_FALSE(asked) << "no step, no record";
}

}  // namespace
}  // namespace anatomesh::edit_history_test
