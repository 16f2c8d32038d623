// Project files that were damaged, and processes that were killed while they wrote one.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "anatomesh_io/project/project_for_test.h"
#include "anatomesh_io/project/record_line.h"

namespace anatomesh::project_hostile_test {
namespace {

using namespace drawing_for_test;
using namespace project_for_test;

// Writes edits until it is killed, and says the number of each once it is kept.
[[noreturn]] void edit_until_killed(const std::string& path, unsigned seed, int acknowledge) {
    RandomMoves moves(seed);
    RunContext context;
    auto project = ProjectFile::create(path, some_source);
    for (std::uint32_t n = 1; project.ok(); ++n) {
        if (!moves.move(project.value()).ok()) ::_exit(1);
        if (::write(acknowledge, &n, sizeof n) != sizeof n) ::_exit(2);
    }
    ::_exit(3);
}

TEST(ProjectKills, a_killed_process_leaves_every_acknowledged_step_and_nothing_torn) {
    const Folder folder;
    std::mt19937 random(7);
    std::uint32_t acknowledged_in_all = 0;
    for (unsigned seed = 0; seed < 100; ++seed) {
        const std::string path = folder.file("p" + std::to_string(seed));
        int ends[2];
        ASSERT_EQ(::pipe(ends), 0);
        const pid_t child = ::fork();
        if (child == 0) edit_until_killed(path, seed, ends[1]);
        ::close(ends[1]);
        // The first acknowledgement is waited for, so that there is a project to kill.
        std::uint32_t last = 0, n = 0;
        ASSERT_EQ(::read(ends[0], &n, sizeof n), static_cast<ssize_t>(sizeof n));
        std::this_thread::sleep_for(std::chrono::microseconds(random() % 20'000));
        ::kill(child, SIGKILL);
        int status = 0;
        ::waitpid(child, &status, 0);
        ASSERT_TRUE(WIFSIGNALED(status)) << "it ended by itself with " << WEXITSTATUS(status);
        do last = n;
        while (::read(ends[0], &n, sizeof n) == static_cast<ssize_t>(sizeof n));
        ::close(ends[0]);
        acknowledged_in_all += last;

        RunContext context;
        const ProjectFile project = opened(path, context);
        const std::uint64_t kept = project.records() - 1;
        ASSERT_GE(kept, last);
        ASSERT_LE(kept, last + 1);
        RandomMoves moves(seed);
        EditHistory expected((Drawing(some_source)));
        for (std::uint64_t m = 0; m < kept; ++m) good(moves.move(expected));
        ASSERT_TRUE(same_history(project.history(), expected)) << seed;
    }
    EXPECT_GT(acknowledged_in_all, 200u);
}

// A project file of some steps, and the drawing after each of its records.
struct Noted {
    std::string text;
    std::vector<EditHistory> histories;  // by the number of records read, from 1
};

Noted noted_project(unsigned seed) {
    const Folder folder;
    Noted noted;
    {
        ProjectFile project = created(folder.file("p"));
        RandomMoves moves(seed);
        noted.histories.push_back(project.history());
        for (int n = 0; n < 60; ++n) {
            good(moves.move(project));
            noted.histories.push_back(project.history());
        }
    }
    noted.text = content_of(folder.file("p"));
    return noted;
}

std::string mutated(std::string text, std::mt19937& random) {
    const auto at = [&] { return random() % (text.size() + 1); };
    for (std::uint32_t n = 1 + random() % 3; n-- > 0;) {
        const std::size_t a = at(), b = std::min(text.size(), a + random() % 200);
        switch (random() % 6) {
            case 0:
                if (a < text.size()) text[a] = static_cast<char>(random());
                break;
            case 1:
                text.erase(a, b - a);
                break;
            case 2:
                text.insert(at(), text.substr(a, b - a));
                break;
            case 3:
                text.resize(a);
                break;
            case 4:
                text.insert(a, std::string(random() % 50, static_cast<char>(random())));
                break;
            default:
                std::fill(text.begin() + static_cast<std::ptrdiff_t>(a),
                          text.begin() + static_cast<std::ptrdiff_t>(b), '\0');
        }
    }
    return text;
}

TEST(ProjectMutations, a_damaged_file_gives_a_drawing_that_was_there_or_an_error) {
    const Noted noted = noted_project(3);
    std::mt19937 random(11);
    int read_ones = 0, refused = 0;
    for (int n = 0; n < 600; ++n) {
        const std::string text = mutated(noted.text, random);
        for (const bool readable_part : {false, true}) {
            RunContext context;
            const auto project = replay_project(text, "file", {{}, readable_part}, context);
            if (!project.ok()) {
                ++refused;
                EXPECT_TRUE(project.error().code == "E-PRJ-001" || project.error().code == "E-PRJ-003" ||
                            project.error().code == "E-PRJ-004")
                    << to_line(project.error());
                continue;
            }
            ++read_ones;
            ASSERT_LE(project.value().records, noted.histories.size());
            EXPECT_TRUE(same_history(project.value().history, noted.histories[project.value().records - 1]));
            EXPECT_EQ(project.value().is_cut, !context.warnings.empty());
        }
    }
    EXPECT_GT(read_ones, 100);
    EXPECT_GT(refused, 100);
}

TEST(ProjectMutations, whole_lines_that_are_missing_twice_or_exchanged_are_told) {
    const Noted noted = noted_project(4);
    std::vector<std::string> lines;
    for (const std::string_view record : scan_records(noted.text).records)
        lines.push_back(record_line(record));
    std::mt19937 random(12);
    for (int n = 0; n < 200; ++n) {
        std::vector<std::string> changed = lines;
        const std::size_t at = random() % (lines.size() - 2);
        if (n % 3 == 0) changed.erase(changed.begin() + static_cast<std::ptrdiff_t>(at));
        if (n % 3 == 1) changed.insert(changed.begin() + static_cast<std::ptrdiff_t>(at), changed[at]);
        if (n % 3 == 2) std::swap(changed[at], changed[at + 1]);
        std::string text;
        for (const std::string& line : changed) text += line;
        RunContext context;
        const auto project = replay_project(text, "file", {}, context);
        ASSERT_FALSE(project.ok());
        EXPECT_TRUE(project.error().code == "E-PRJ-004" || (at == 0 && project.error().code == "E-PRJ-001"))
            << to_line(project.error());
    }
}

// The checksum is right, and the record is not what the program writes: somebody else wrote it.
TEST(ProjectMutations, records_with_a_right_checksum_are_not_trusted) {
    const Noted noted = noted_project(5);
    std::vector<std::string> records;
    for (const std::string_view record : scan_records(noted.text).records) records.emplace_back(record);
    std::mt19937 random(13);
    int read_ones = 0, refused = 0;
    for (int n = 0; n < 1000; ++n) {
        const std::size_t at = random() % records.size();
        std::string text;
        for (std::size_t r = 0; r < records.size(); ++r) {
            std::string record = r == at ? mutated(records[r], random) : records[r];
            // Numbers and words are exchanged more often than bytes.
            if (r == at && n % 2 == 0) {
                record = records[r];
                const std::string words[] = {"null", "-1",   "1e9",        "true", "[]",
                                             "{}",   "\"\"", "4294967296", "0.5"};
                const std::size_t digit = record.find_first_of("0123456789", random() % record.size());
                if (digit != std::string::npos) record.replace(digit, 1, words[random() % std::size(words)]);
            }
            text += record_line(record);
        }
        RunContext context;
        const auto project = replay_project(text, "file", {}, context);
        (project.ok() ? read_ones : refused) += 1;
        // Whatever was read is a drawing: all of it can be undone, and redone.
        if (!project.ok()) continue;
        EditHistory history = project.value().history;
        while (history.undo().value()) {
        }
        EXPECT_TRUE(history.drawing().rings().entries().empty());
    }
    EXPECT_GT(read_ones, 50);
    EXPECT_GT(refused, 200);
}

TEST(ProjectMutations, a_small_file_cannot_ask_for_much_memory) {
    const Folder folder;
    std::string text;
    {
        ProjectFile project = created(folder.file("p"));
        std::mt19937 random(1);
        const Plane plane = make_plane({0, 0, 5}, {0, 0, 1});
        good(project.apply(add_structure(project.drawing(), {{1, "liver", {1, 2, 3}}, false}, "Add")));
        good(project.apply(add_plane(project.drawing(), 7, {plane, "", 0, false}, "Add")));
        good(project.apply(set_rings(project.drawing(), {7, 1}, star_rings(plane, random, 1, 1000), "Draw")));
        text = content_of(folder.file("p"));
    }
    // Each ring takes all that stood there.
    const std::string ring = R"({"tool":"stroke","from":0,"head":1000,"tail":0,"points":""})";
    const auto record = [&](const std::string& rings) {
        return record_line(R"({"n":4,"do":"apply","name":"Draw","changes":[{"rings":[7,1],"to":[)" + rings +
                           "]}]}");
    };
    RunContext context;
    const auto twice = replay_project(text + record(ring + "," + ring), "file", {}, context);
    ASSERT_FALSE(twice.ok());
    EXPECT_EQ(twice.error().code, "E-PRJ-004");
    // Steps that add a point each to the thousand that stand there.
    for (int n = 0; n < 3; ++n) {
        text += record_line(R"({"n":)" + std::to_string(4 + n) +
                            R"(,"do":"apply","name":"Draw","changes":[{"rings":[7,1],"to":[)" +
                            R"({"tool":"stroke","from":0,"head":1000,"tail":0,"points":"0 0 )" +
                            (n % 2 == 0 ? "5" : "5.001") + "\"}]}]}");
    }
    EXPECT_TRUE(replay_project(text, "file", {}, context).ok());
    ReadProjectOptions options;
    options.limits.points = 3500;
    const auto limited = replay_project(text, "file", options, context);
    ASSERT_FALSE(limited.ok());
    EXPECT_EQ(limited.error().code, "E-PRJ-011");
    EXPECT_EQ(limited.error().kind, ErrorKind::limit);
    options.readable_part = true;
    EXPECT_FALSE(replay_project(text, "file", options, context).ok()) << "what is too large is not damaged";
    EXPECT_EQ(limited.error().place.value.substr(0, 8), "record 6");
    // Nested deep, and long numbers: JSON that is allowed, and costs no stack.
    const std::string deep = std::string(500'000, '[') + std::string(500'000, ']');
    EXPECT_EQ(replay_project(text + record_line(R"({"n":7,"do":"apply","name":"","changes":)" + deep + "}"),
                             "file", {}, context)
                  .error()
                  .code,
              "E-PRJ-004");
}

}  // namespace
}  // namespace anatomesh::project_hostile_test
