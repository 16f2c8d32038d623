#include "anatomesh_io/file/atomic_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>
#include <thread>

namespace anatomesh::atomic_file_test {
namespace {

namespace fs = std::filesystem;

// An empty folder that goes with the test.
struct Folder {
    fs::path path;
    Folder() {
        std::string name = (fs::temp_directory_path() / "atomic_file_XXXXXX").string();
        path = ::mkdtemp(name.data());
    }
    ~Folder() {
        ::chmod(path.c_str(), 0700);
        fs::remove_all(path);
    }
    std::string file(const std::string& name) const { return (path / name).string(); }
    std::size_t entries() const {
        return static_cast<std::size_t>(
            std::distance(fs::directory_iterator(path), fs::directory_iterator()));
    }
};

std::string content_of(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

void put(const std::string& path, const std::string& content) {
    std::ofstream(path, std::ios::binary) << content;
}

// Fails the n-th call of all, with an errno or (for write) a short count.
class FailingCalls : public SystemCalls {
  public:
    FailingCalls(int n, int why, bool short_write) : n_(n), why_(why), short_write_(short_write) {}
    int calls() const { return count_; }
    const std::string& failed() const { return failed_; }

    int open(const char* path, int flags, mode_t mode) override {
        return fails("open") ? -1 : SystemCalls::open(path, flags, mode);
    }
    ssize_t write(int descriptor, const void* data, std::size_t size) override {
        if (!fails("write")) return SystemCalls::write(descriptor, data, std::min<std::size_t>(size, 4096));
        return short_write_ ? SystemCalls::write(descriptor, data, size / 2) : -1;
    }
    int fsync(int descriptor) override { return fails("fsync") ? -1 : SystemCalls::fsync(descriptor); }
    int close(int descriptor) override {
        SystemCalls::close(descriptor);  // the descriptor is gone on Linux whatever close says
        return fails("close") ? -1 : 0;
    }
    int rename(const char* from, const char* to) override {
        return fails("rename") ? -1 : SystemCalls::rename(from, to);
    }
    int exchange(const char* one, const char* other) override {
        if (no_exchange) {
            errno = ENOSYS;
            return -1;
        }
        return fails("exchange") ? -1 : SystemCalls::exchange(one, other);
    }
    bool no_exchange = false;

  private:
    bool fails(const char* name) {
        if (++count_ != n_) return false;
        if (short_write_ && std::string(name) != "write") return false;
        failed_ = name;
        errno = why_;
        return true;
    }
    int n_, why_, count_ = 0;
    bool short_write_;
    std::string failed_;
};

TEST(AtomicFile, writes_and_replaces) {
    const Folder folder;
    const std::string path = folder.file("model.vtu");
    ASSERT_TRUE(write_file_atomically(path, "one").ok());
    EXPECT_EQ(content_of(path), "one");
    ::chmod(path.c_str(), 0640);
    ASSERT_TRUE(write_file_atomically(path, std::string(100'000, 'x')).ok());
    EXPECT_EQ(content_of(path), std::string(100'000, 'x'));
    struct stat status {};
    ::stat(path.c_str(), &status);
    EXPECT_EQ(status.st_mode & 0777, 0640u);
    EXPECT_EQ(folder.entries(), 1u);
    ASSERT_TRUE(write_file_atomically(path, "").ok());
    EXPECT_EQ(content_of(path), "");
}

TEST(AtomicFile, nothing_appears_before_commit) {
    const Folder folder;
    const std::string path = folder.file("a");
    put(path, "old");
    {
        auto file = AtomicFile::create(path);
        ASSERT_TRUE(file.ok());
        ASSERT_TRUE(file.value().write("new").ok());
        EXPECT_EQ(content_of(path), "old");
        EXPECT_EQ(folder.entries(), 2u);
    }
    EXPECT_EQ(content_of(path), "old");
    EXPECT_EQ(folder.entries(), 1u);
}

TEST(AtomicFile, follows_a_symbolic_link) {
    const Folder folder, elsewhere;
    put(elsewhere.file("real"), "old");
    fs::create_symlink(elsewhere.file("real"), folder.file("link"));
    ASSERT_TRUE(write_file_atomically(folder.file("link"), "new").ok());
    EXPECT_TRUE(fs::is_symlink(folder.file("link")));
    EXPECT_EQ(content_of(elsewhere.file("real")), "new");
}

TEST(AtomicFile, F01_disk_full_leaves_the_old_file) {
    // The temporary file is /dev/full: the kernel itself says ENOSPC.
    class FullDisk : public SystemCalls {
        int open(const char* path, int flags, mode_t mode) override {
            if (flags & O_CREAT) return SystemCalls::open("/dev/full", O_WRONLY, 0);
            return SystemCalls::open(path, flags, mode);
        }
    } full;
    const Folder folder;
    const std::string path = folder.file("model.vtu");
    put(path, "old");
    const Status status = write_file_atomically(path, std::string(10'000, 'x'), full);
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(status.error().kind, ErrorKind::file);
    EXPECT_EQ(status.error().code, "E-FILE-008");
    EXPECT_EQ(status.error().place.file, path);
    EXPECT_NE(status.error().message.find("after 0 bytes"), std::string::npos) << status.error().message;
    EXPECT_EQ(content_of(path), "old");
    EXPECT_EQ(folder.entries(), 1u);
}

TEST(AtomicFile, F01_file_size_limit_at_64_sizes) {
    const Folder folder;
    const std::string path = folder.file("model.vtu");
    put(path, "old");
    constexpr std::size_t size = 64 * 1000;
    for (std::size_t limit = 0; limit < size; limit += 1000) {
        const pid_t child = ::fork();
        ASSERT_GE(child, 0);
        if (child == 0) {
            const rlimit most{limit, limit};
            ::setrlimit(RLIMIT_FSIZE, &most);
            const Status status = write_file_atomically(path, std::string(size, 'x'));
            const bool said =
                !status.ok() && status.error().kind == ErrorKind::file &&
                status.error().message.find("after " + std::to_string(limit) + " bytes") != std::string::npos;
            ::_exit(said ? 6 : 1);
        }
        int state = 0;
        ::waitpid(child, &state, 0);
        ASSERT_TRUE(WIFEXITED(state)) << "signal " << WTERMSIG(state) << " at limit " << limit;
        ASSERT_EQ(WEXITSTATUS(state), 6) << "at limit " << limit;
        ASSERT_EQ(content_of(path), "old");
        ASSERT_EQ(folder.entries(), 1u);
    }
}

TEST(AtomicFile, F01_device_as_output_is_refused) {
    const Status status = write_file_atomically("/dev/full", "x");
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(status.error().code, "E-FILE-006");
    EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

// Runs `write` with the n-th call failing, for n = 1, 2, ... until a run is not touched. Gives how often it
// failed.
int fail_every_call(int why, bool short_write, bool no_exchange,
                    const std::function<void(FailingCalls&, const std::string&)>& round) {
    int refused = 0;
    for (int n = 1; n < 1000; ++n) {
        FailingCalls calls(n, why, short_write);
        calls.no_exchange = no_exchange;
        round(calls, "call " + std::to_string(n));
        if (calls.calls() < n) return refused;
        if (!calls.failed().empty()) ++refused;
    }
    ADD_FAILURE() << "no untouched run";
    return refused;
}

TEST(AtomicFile, F02_any_call_fails_with_any_error) {
    const std::string data(30'000, 'x');
    for (const bool no_exchange : {false, true}) {
        for (const int why : {ENOSPC, EIO, EACCES, EINTR, EDQUOT, EMFILE, 0}) {
            const bool short_write = why == 0;
            const int failed = fail_every_call(
                why, short_write, no_exchange, [&](FailingCalls& calls, const std::string& where) {
                    const Folder folder;
                    const std::string path = folder.file("model.vtu");
                    put(path, "old");
                    const Status status = write_file_atomically(path, data, calls);
                    const std::string all = where + ", " + calls.failed() + ", errno " + std::to_string(why);
                    if (status.ok()) {
                        EXPECT_EQ(content_of(path), data) << all;
                    } else {
                        EXPECT_EQ(status.error().kind, ErrorKind::file) << all;
                        EXPECT_EQ(status.error().place.file, path) << all;
                        EXPECT_NE(why, EINTR) << all;
                        EXPECT_FALSE(short_write) << all;
                        // Without exchange the folder's sync comes after the old content is gone.
                        const std::string now = content_of(path);
                        EXPECT_TRUE(now == "old" || (no_exchange && now == data)) << all;
                    }
                    EXPECT_EQ(folder.entries(), 1u) << all;
                });
            EXPECT_GT(failed, 5) << "errno " << why;
        }
    }
}

TEST(AtomicFileSet, F02_outputs_appear_together_or_not_at_all) {
    for (const int why : {ENOSPC, EIO, EINTR}) {
        fail_every_call(why, false, false, [&](FailingCalls& calls, const std::string& where) {
            const Folder folder;
            put(folder.file("old"), "old");
            const auto run = [&]() -> Status {
                AtomicFileSet set(calls);
                ANATOMESH_CHECK_STATUS(set.add(folder.file("old"), "new old"));
                ANATOMESH_CHECK_STATUS(set.add(folder.file("fresh"), "new fresh"));
                ANATOMESH_CHECK_STATUS(set.add(folder.file("third"), "new third"));
                return set.commit();
            };
            const bool ok = run().ok();
            EXPECT_EQ(content_of(folder.file("old")), ok ? "new old" : "old") << where << calls.failed();
            EXPECT_EQ(fs::exists(folder.file("fresh")), ok) << where << calls.failed();
            EXPECT_EQ(fs::exists(folder.file("third")), ok) << where << calls.failed();
            EXPECT_EQ(folder.entries(), ok ? 3u : 1u) << where << calls.failed();
        });
    }
}

TEST(AtomicFileSet, what_fails_last_takes_all_back) {
    const Folder folder;
    put(folder.file("old"), "old");
    AtomicFileSet set;
    ASSERT_TRUE(set.add(folder.file("old"), "new old").ok());
    ASSERT_TRUE(set.add(folder.file("fresh"), "new fresh").ok());
    bool were_there = false;
    const Status status = set.commit([&]() -> Status {
        were_there = content_of(folder.file("old")) == "new old" && fs::exists(folder.file("fresh"));
        return Error{ErrorKind::file, "E-FILE-008", "the answer could not be given", {}, ""};
    });
    EXPECT_TRUE(were_there);
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(status.error().code, "E-FILE-008");
    EXPECT_EQ(content_of(folder.file("old")), "old");
    EXPECT_EQ(folder.entries(), 1u);
}

TEST(AtomicFileSet, two_outputs_of_one_name_are_refused) {
    const Folder folder;
    AtomicFileSet set;
    ASSERT_TRUE(set.add(folder.file("a"), "1").ok());
    const Status status = set.add((folder.path / "." / "a").string(), "2");
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(status.error().code, "E-FILE-012");
}

std::string refusal(const std::string& path) {
    const Status status = check_writable(path);
    if (status.ok()) return "ok";
    EXPECT_EQ(status.error().kind, ErrorKind::file);
    EXPECT_FALSE(status.error().next_step.empty());
    return status.error().code;
}

TEST(AtomicFile, F03_paths_that_cannot_be_written) {
    const Folder folder;
    EXPECT_EQ(refusal(folder.file("new")), "ok");
    EXPECT_EQ(folder.entries(), 0u);
    EXPECT_EQ(refusal(folder.file("none/new")), "E-FILE-001");
    put(folder.file("plain"), "old");
    EXPECT_EQ(refusal(folder.file("plain")), "ok");
    EXPECT_EQ(refusal(folder.file("plain/new")), "E-FILE-001");
    fs::create_directory(folder.file("sub"));
    EXPECT_EQ(refusal(folder.file("sub")), "E-FILE-004");
    EXPECT_EQ(refusal(folder.file("sub/")), "E-FILE-004");
    EXPECT_EQ(refusal(folder.file("sub/none/")), "E-FILE-004");
    EXPECT_EQ(refusal(folder.file(std::string(5000, 'a'))), "E-FILE-005");
    EXPECT_EQ(refusal(folder.file(std::string(256, 'a'))), "E-FILE-005");
    EXPECT_EQ(refusal(folder.file(std::string(255, 'a'))), "ok");
    EXPECT_EQ(refusal(""), "E-FILE-011");
    ::chmod(folder.file("plain").c_str(), 0444);
    EXPECT_EQ(refusal(folder.file("plain")), "E-FILE-003");
    ::chmod(folder.file("sub").c_str(), 0555);
    EXPECT_EQ(refusal(folder.file("sub/new")), "E-FILE-002");
    ::chmod(folder.file("sub").c_str(), 0755);
    ::mkfifo(folder.file("pipe").c_str(), 0666);
    EXPECT_EQ(refusal(folder.file("pipe")), "E-FILE-006");
    EXPECT_EQ(content_of(folder.file("plain")), "old");
}

TEST(AtomicFile, F04_killed_at_any_time_leaves_the_old_or_the_new_file) {
    const Folder folder;
    const std::string path = folder.file("model.vtu");
    const std::string even(300'000, 'e'), odd(500'000, 'o');
    put(path, even);
    std::mt19937 random(4);
    int with_rest = 0;
    for (int round = 0; round < 200; ++round) {
        const pid_t child = ::fork();
        ASSERT_GE(child, 0);
        if (child == 0) {
            for (int i = 0;; ++i)
                static_cast<void>(write_file_atomically(path, i % 2 == 0 ? odd : even).ok());
        }
        std::this_thread::sleep_for(std::chrono::microseconds(random() % 6000));
        ::kill(child, SIGKILL);
        ::waitpid(child, nullptr, 0);
        const std::string now = content_of(path);
        ASSERT_TRUE(now == even || now == odd) << now.size() << " bytes after round " << round;
        if (folder.entries() > 1) ++with_rest;
    }
    EXPECT_GT(with_rest, 0) << "never killed while writing: the test shows nothing";
    ASSERT_TRUE(check_writable(path).ok());
    EXPECT_EQ(folder.entries(), 1u) << "the next start removes what killed runs left";
}

// Ends the process, as a kill does, instead of the n-th call.
class DeadlyCalls : public SystemCalls {
  public:
    DeadlyCalls(int n, bool with_exchange) : n_(n), with_exchange_(with_exchange) {}
    int open(const char* path, int flags, mode_t mode) override {
        strike();
        return SystemCalls::open(path, flags, mode);
    }
    ssize_t write(int descriptor, const void* data, std::size_t size) override {
        strike();
        return SystemCalls::write(descriptor, data, std::min<std::size_t>(size, 7));
    }
    int fsync(int descriptor) override {
        strike();
        return SystemCalls::fsync(descriptor);
    }
    int rename(const char* from, const char* to) override {
        strike();
        return SystemCalls::rename(from, to);
    }
    int exchange(const char* one, const char* other) override {
        strike();
        if (with_exchange_) return SystemCalls::exchange(one, other);
        errno = ENOSYS;
        return -1;
    }
    int unlink(const char* path) override {
        strike();
        return SystemCalls::unlink(path);
    }

  private:
    void strike() {
        if (++count_ == n_) ::_exit(9);
    }
    int n_, count_ = 0;
    bool with_exchange_;
};

const std::vector<std::string> set_of_three{"old", "fresh", "third"};

Status write_set(const Folder& folder, SystemCalls& calls) {
    AtomicFileSet set(calls);
    for (const std::string& name : set_of_three) {
        ANATOMESH_CHECK_STATUS(set.add(folder.file(name), "new " + name));
    }
    return set.commit();
}

// Whether a run that was to write the set was killed at the n-th call; `after` is called then.
bool killed_at(const Folder& folder, int n, bool with_exchange) {
    const pid_t child = ::fork();
    if (child == 0) {
        DeadlyCalls calls(n, with_exchange);
        ::_exit(write_set(folder, calls).ok() ? 0 : 1);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) != 1);
    return WEXITSTATUS(status) == 9;
}

TEST(AtomicFileSet, F04_killed_at_any_call_all_outputs_are_new_after_the_next_start_or_none) {
    for (const bool with_exchange : {true, false}) {
        int all_new = 0, none = 0, between = 0;
        for (int n = 1;; ++n) {
            const Folder folder;
            put(folder.file("old"), "old");
            const bool killed = killed_at(folder, n, with_exchange);
            if (!killed) break;
            between += content_of(folder.file("old")) == "new old" && !fs::exists(folder.file("third"));
            ASSERT_TRUE(check_writable(folder.file("another")).ok());
            const bool is_new = content_of(folder.file("old")) == "new old";
            ++(is_new ? all_new : none);
            for (const std::string& name : set_of_three) {
                const std::string before = name == "old" ? "old" : "";
                EXPECT_EQ(content_of(folder.file(name)), is_new ? "new " + name : before) << n;
            }
            EXPECT_EQ(folder.entries(), is_new ? 3u : 1u) << n;
        }
        EXPECT_GT(all_new, 3);
        EXPECT_GT(none, 10);
        EXPECT_GT(between, 0) << "never killed between two renames: the test shows nothing";
    }
}

// What somebody wrote after the kill is his.
TEST(AtomicFileSet, F04_a_target_that_changed_since_the_kill_stays) {
    for (int n = 1;; ++n) {
        const Folder folder;
        put(folder.file("old"), "old");
        if (!killed_at(folder, n, true)) break;
        put(folder.file("third"), "of the user");
        ASSERT_TRUE(check_writable(folder.file("another")).ok());
        EXPECT_EQ(content_of(folder.file("third")), "of the user") << n;
    }
}

// Nobody can have files of another user renamed, or files that are none of a run's.
TEST(AtomicFileSet, F04_journals_of_others_and_damaged_ones_do_nothing) {
    const Folder folder;
    pid_t dead = ::fork();
    if (dead == 0) ::_exit(0);
    ::waitpid(dead, nullptr, 0);
    // The name of a temporary file tells the machine's tag.
    std::string journal;
    {
        auto mine = AtomicFile::create(folder.file("a"));
        ASSERT_TRUE(mine.ok());
        for (const auto& entry : fs::directory_iterator(folder.path)) journal = entry.path().string();
    }
    const std::string own = std::to_string(::getpid());
    journal.replace(journal.find("-" + own + "-"), own.size() + 2, "-" + std::to_string(dead) + "-");
    const std::string temporary = journal;
    journal += ".set";
    put(folder.file("victim"), "old");
    put(folder.file("evil"), "evil");
    const std::string zero(1, '\0');
    const auto journal_of = [&](const std::string& from) {
        return from + zero + folder.file("victim") + zero + "none" + zero + "none" + zero + "end of the set" +
               zero;
    };
    std::mt19937 random(8);
    for (int round = 0; round < 300; ++round) {
        std::string bytes = journal_of(round % 2 ? folder.file("evil") : temporary);
        for (int flips = round % 5; flips > 0; --flips) bytes[random() % bytes.size()] ^= 1 << random() % 8;
        if (round % 3 == 0) bytes.resize(random() % bytes.size());
        put(journal, bytes);
        ASSERT_TRUE(check_writable(folder.file("another")).ok());
        ASSERT_EQ(content_of(folder.file("victim")), "old");
        ASSERT_EQ(content_of(folder.file("evil")), "evil");
    }
    if (::geteuid() != 0) return;  // none but root can make files of another user
    put(temporary, "evil");
    struct stat state {};
    ASSERT_EQ(::stat(temporary.c_str(), &state), 0);
    put(journal, journal_of(temporary));
    ASSERT_EQ(::chown(journal.c_str(), 12345, 12345), 0);
    ASSERT_TRUE(check_writable(folder.file("another")).ok());
    EXPECT_EQ(content_of(folder.file("victim")), "old");
    EXPECT_TRUE(fs::exists(journal)) << "a journal of another user is left alone";
}

TEST(AtomicFile, F04_temporaries_of_living_runs_and_other_files_stay) {
    const Folder folder;
    auto living = AtomicFile::create(folder.file("a"));
    ASSERT_TRUE(living.ok());
    put(folder.file(".anatomesh-1-999999-0.tmp"), "of another machine");
    put(folder.file(".anatomesh-notes.tmp"), "of the user");
    ASSERT_TRUE(check_writable(folder.file("b")).ok());
    EXPECT_EQ(folder.entries(), 3u);
}

}  // namespace
}  // namespace anatomesh::atomic_file_test
