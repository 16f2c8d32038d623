#include "anatomesh_io/network/object_store.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>

#include "anatomesh_io/dicom/dicom_writer.h"
#include "anatomesh_io/dicom/tags.h"
#include "anatomesh_io/network/dcmtk_door.h"

namespace anatomesh::object_store_test {
namespace {

namespace fs = std::filesystem;

constexpr const char* ct_class = "1.2.840.10008.5.1.4.1.1.2";

std::string data_set(const std::string& instance, const std::string& study = "1.2.3",
                     const std::string& series = "1.2.3.4", const std::string& extra = "x") {
    DicomWriter writer(DicomWriter::Syntax::explicit_little);
    writer.element(tags::sop_class, "UI", ct_class);
    writer.element(tags::sop_instance, "UI", instance);
    if (!study.empty()) writer.element(tags::study_instance, "UI", study);
    if (!series.empty()) writer.element(tags::series_instance, "UI", series);
    writer.element(tags::pixel_data, "OW", extra);
    return writer.bytes();
}

class Folder : public ::testing::Test {
  protected:
    void SetUp() override {
        char name[] = "/tmp/anatomesh-store-XXXXXX";
        ASSERT_NE(::mkdtemp(name), nullptr);
        folder = name;
    }
    void TearDown() override { fs::remove_all(folder); }

    ObjectStore open(const ObjectStoreOptions& options = {}, SystemCalls& calls = SystemCalls::real()) {
        auto store = ObjectStore::open(folder + "/store", options, calls);
        EXPECT_TRUE(store.ok());
        return std::move(store).value();
    }
    StoreOutcome put(ObjectStore& store, const std::string& instance, const std::string& data,
                     const std::string& syntax = explicit_little_syntax) {
        ObjectStore::Incoming incoming(store, {ct_class, instance, syntax});
        incoming.begin_data_set();
        for (std::size_t at = 0; at < data.size(); at += 7)
            incoming.write(std::string_view(data).substr(at, 7));
        return incoming.finish();
    }
    // All files in the folder, hidden ones too.
    std::vector<std::string> files() const {
        std::vector<std::string> all;
        for (const auto& each : fs::recursive_directory_iterator(folder))
            if (each.is_regular_file()) all.push_back(fs::relative(each.path(), folder + "/store").string());
        std::sort(all.begin(), all.end());
        return all;
    }

    std::string folder;
};
using Store = Folder;

TEST_F(Store, an_object_goes_to_its_place) {
    ObjectStore store = open();
    const StoreOutcome outcome = put(store, "1.2.5", data_set("1.2.5"));
    EXPECT_EQ(outcome.status, 0);
    EXPECT_EQ(outcome.path, "1.2.3/1.2.3.4/1.2.5.dcm");
    EXPECT_EQ(files(), std::vector<std::string>{"1.2.3/1.2.3.4/1.2.5.dcm"});
    EXPECT_EQ(store.used_bytes(), fs::file_size(folder + "/store/" + outcome.path));
    const MappedFile file(folder + "/store/" + outcome.path);
    const auto identity = identify_object(file.bytes(), "file");
    ASSERT_TRUE(identity.ok());
    EXPECT_EQ(identity.value().series, "1.2.3.4");
}

TEST_F(Store, A15_the_same_again_and_another_of_the_same_name) {
    ObjectStore store = open();
    EXPECT_EQ(put(store, "1.2.5", data_set("1.2.5")).end, StoreEnd::stored);
    EXPECT_EQ(put(store, "1.2.5", data_set("1.2.5")).end, StoreEnd::there_already);
    const StoreOutcome other = put(store, "1.2.5", data_set("1.2.5", "1.2.3", "1.2.3.4", "other"));
    EXPECT_EQ(other.end, StoreEnd::refused);
    EXPECT_EQ(other.status >> 12, 0xC);
    EXPECT_EQ(files().size(), 1u);
}

TEST_F(Store, A14_names_from_outside_never_become_paths) {
    ObjectStore store = open();
    std::string nul("1.2\0/../x", 9);
    for (const std::string& name : {std::string("../../x"), std::string("/etc/x"), std::string(1000, 'u'),
                                    std::string("a/b"), nul, std::string("..")}) {
        const StoreOutcome outcome = put(store, name, data_set(name, name, name));
        EXPECT_EQ(outcome.status, 0) << name;
    }
    for (const std::string& file : files()) {
        EXPECT_EQ(std::count(file.begin(), file.end(), '/'), 2) << file;
        EXPECT_EQ(file.find(".."), std::string::npos) << file;
    }
    EXPECT_EQ(files().size(), 6u);
    std::size_t outside = 0;
    for (const auto& each : fs::directory_iterator(folder)) outside += each.path().filename() != "store";
    EXPECT_EQ(outside, 0u);
}

TEST_F(Store, A14_A08_an_object_that_is_not_what_was_said) {
    ObjectStore store = open();
    EXPECT_EQ(put(store, "1.2.5", data_set("1.2.6")).status, dimse::does_not_match_class);
    EXPECT_EQ(put(store, "1.2.5", data_set("1.2.5", "")).status >> 12, 0xC);
    EXPECT_EQ(put(store, "1.2.5", data_set("1.2.5", "1.2", "")).status >> 12, 0xC);
    EXPECT_EQ(put(store, "1.2.5", "").status, dimse::does_not_match_class);
    EXPECT_TRUE(files().empty());
}

TEST_F(Store, A17_every_cut_and_random_changes) {
    ObjectStore store = open();
    const std::string good = data_set("1.2.5");
    const std::string meta = meta_header({ct_class, "1.2.5", explicit_little_syntax});
    for (std::size_t size = 0; size < good.size(); ++size) {
        static_cast<void>(identify_object(meta + good.substr(0, size), "file"));
        if (size % 8 == 0) static_cast<void>(put(store, "1.2.5", good.substr(0, size)));
    }
    std::mt19937 random(3);
    for (int i = 0; i < 20000; ++i) {
        std::string bytes = meta + good;
        for (int k = 0; k < 3; ++k) bytes[random() % bytes.size()] = static_cast<char>(random());
        static_cast<void>(identify_object(bytes, "file"));
        if (i % 500 == 0) static_cast<void>(put(store, "1.2.5", bytes.substr(meta.size())));
    }
    for (const std::string& file : files()) EXPECT_TRUE(file.ends_with(".dcm")) << file;
}

TEST_F(Store, A13_the_quota_holds_and_what_is_there_stays) {
    ObjectStoreOptions options;
    options.quota_bytes = 5000;
    {
        ObjectStore store = open(options);
        EXPECT_EQ(put(store, "1.2.5", data_set("1.2.5", "1.2", "1.2", std::string(3000, 'x'))).status, 0);
        const StoreOutcome outcome =
            put(store, "1.2.6", data_set("1.2.6", "1.2", "1.2", std::string(3000, 'x')));
        EXPECT_EQ(outcome.status, dimse::out_of_resources);
        EXPECT_EQ(files().size(), 1u);
    }
    // Another process knows what is there.
    ObjectStore store = open(options);
    EXPECT_EQ(put(store, "1.2.6", data_set("1.2.6", "1.2", "1.2", std::string(3000, 'x'))).status,
              dimse::out_of_resources);
    ObjectStoreOptions small;
    small.max_object_bytes = 1000;
    EXPECT_FALSE(ObjectStore::open(folder + "/store", small).ok());  // F08: one process at a time
}

// The n-th call fails, for every n until none does.
class Failing : public SystemCalls {
  public:
    explicit Failing(int fails_at, int with) : left_(fails_at), with_(with) {}
    int open(const char* path, int flags, mode_t mode) override {
        return fails() ? -1 : SystemCalls::open(path, flags, mode);
    }
    ssize_t write(int descriptor, const void* data, std::size_t size) override {
        return fails() ? -1 : SystemCalls::write(descriptor, data, size);
    }
    int fsync(int descriptor) override { return fails() ? -1 : SystemCalls::fsync(descriptor); }
    int rename(const char* from, const char* to) override {
        return fails() ? -1 : SystemCalls::rename(from, to);
    }
    bool has_failed() const { return left_ < 0; }

  private:
    bool fails() {
        if (left_ < 0 || left_-- > 0) return false;
        errno = with_;
        return true;
    }
    int left_, with_;
};

TEST_F(Store, A13_a_disk_that_fails_at_any_call) {
    for (int n = 0;; ++n) {
        ASSERT_LT(n, 100);
        fs::remove_all(folder + "/store");
        fs::create_directory(folder + "/store");
        Failing calls(n, ENOSPC);
        ObjectStore store = open({}, calls);
        const StoreOutcome outcome = put(store, "1.2.5", data_set("1.2.5"));
        if (!calls.has_failed()) {
            EXPECT_EQ(outcome.status, 0);
            EXPECT_GT(n, 5);
            break;
        }
        EXPECT_EQ(outcome.status, dimse::out_of_resources) << n;
        EXPECT_TRUE(files().empty()) << n;
    }
}

// What is at the name of an object, and how it looks afterwards: type, target of a link, size.
std::string look_of(const std::string& path) {
    struct stat state {};
    if (::lstat(path.c_str(), &state) != 0) return "nothing";
    const std::string link = S_ISLNK(state.st_mode) ? fs::read_symlink(path).string() : "";
    return std::to_string(state.st_mode) + " " + std::to_string(state.st_ino) + " " +
           std::to_string(state.st_size) + " " + link;
}

TEST_F(Store, A15_what_cannot_be_read_and_compared_is_never_replaced) {
    const std::string data = data_set("1.2.5"), series = folder + "/store/1.2.3/1.2.3.4";
    const std::string target = series + "/1.2.5.dcm", elsewhere = folder + "/elsewhere.dcm";
    std::ofstream(elsewhere) << meta_header({ct_class, "1.2.5", explicit_little_syntax}) << data;
    const std::vector<std::function<void()>> takers{
        [&] { fs::create_symlink(elsewhere, target); },  // of the same content
        [&] { fs::create_symlink("nowhere", target); }, [&] { fs::create_directory(target); },
        [&] { ASSERT_EQ(::mkfifo(target.c_str(), 0600), 0); },
        [&] {  // larger than what is left of the address space
            std::ofstream(target) << "x";
            fs::resize_file(target, std::uintmax_t{1} << 40);
        }};
    for (std::size_t i = 0; i < takers.size(); ++i) {
        fs::remove_all(folder + "/store");
        fs::create_directories(series);
        takers[i]();
        const std::string before = look_of(target);
        ObjectStore store = open();
        struct rlimit limit {};
        ASSERT_EQ(::getrlimit(RLIMIT_AS, &limit), 0);
        std::uint64_t pages = 0;
        std::ifstream("/proc/self/statm") >> pages;
        const struct rlimit less {
            pages* static_cast<std::uint64_t>(::getpagesize()) + (std::uint64_t{1} << 30), limit.rlim_max
        };
        ASSERT_EQ(::setrlimit(RLIMIT_AS, &less), 0);
        const StoreOutcome outcome = put(store, "1.2.5", data);
        ASSERT_EQ(::setrlimit(RLIMIT_AS, &limit), 0);
        EXPECT_EQ(outcome.end, StoreEnd::refused) << i;
        EXPECT_EQ(outcome.status, dimse::unreadable_there) << i;
        EXPECT_NE(outcome.reason.find("cannot be read"), std::string::npos) << i;
        EXPECT_EQ(look_of(target), before) << i;
    }
    EXPECT_EQ(fs::file_size(elsewhere),
              data.size() + 0u + meta_header({ct_class, "1.2.5", explicit_little_syntax}).size());
}

TEST_F(Store, A15_another_content_never_replaces_an_object_whichever_call_fails) {
    const std::string target = folder + "/store/1.2.3/1.2.3.4/1.2.5.dcm";
    for (const int with : {EACCES, EMFILE, ENFILE, ENOMEM, EIO}) {
        for (int n = 0;; ++n) {
            ASSERT_LT(n, 100);
            fs::remove_all(folder + "/store");
            fs::create_directory(folder + "/store");
            {
                ObjectStore store = open();
                ASSERT_EQ(put(store, "1.2.5", data_set("1.2.5")).end, StoreEnd::stored);
            }
            const std::string before = look_of(target);
            Failing calls(n, with);
            ObjectStore store = open({}, calls);
            const StoreOutcome outcome = put(store, "1.2.5", data_set("1.2.5", "1.2.3", "1.2.3.4", "other"));
            EXPECT_EQ(outcome.end, StoreEnd::refused) << n;
            EXPECT_EQ(look_of(target), before) << n;
            EXPECT_EQ(files().size(), 1u) << n;
            if (!calls.has_failed()) {
                EXPECT_EQ(outcome.status, dimse::other_content);
                EXPECT_GT(n, 4);
                break;
            }
        }
    }
}

TEST_F(Store, only_what_the_filter_takes_is_stored) {
    // Every set of UIDs given, and every set of them that is another than the object's.
    const std::string mine[] = {"1.2", "1.2.3", "1.2.3.4"}, others[] = {"1.3", "1.3.3", "1.3.3.4"};
    for (unsigned given = 0; given < 8; ++given) {
        for (unsigned foreign = 0; foreign < 8; ++foreign) {
            fs::remove_all(folder + "/store");
            ObjectStore store = open();
            store.take_only({given & 1 ? mine[0] : "", given & 2 ? mine[1] : "", given & 4 ? mine[2] : ""});
            const auto uid = [&](unsigned i) { return foreign >> i & 1 ? others[i] : mine[i]; };
            const StoreOutcome outcome = put(store, uid(2), data_set(uid(2), uid(0), uid(1)));
            const bool is_asked = (given & foreign) == 0;
            EXPECT_EQ(outcome.end, is_asked ? StoreEnd::stored : StoreEnd::unasked) << given << foreign;
            EXPECT_EQ(outcome.status, is_asked ? dimse::success : dimse::not_authorized);
            EXPECT_EQ(files().size(), is_asked ? 1u : 0u);
        }
    }
}

TEST_F(Store, A12_what_was_not_finished_is_gone) {
    ObjectStore store = open();
    {
        ObjectStore::Incoming incoming(store, {ct_class, "1.2.5", explicit_little_syntax});
        incoming.begin_data_set();
        incoming.write("half");
        EXPECT_EQ(files().size(), 1u);
    }
    EXPECT_TRUE(files().empty());
}

TEST_F(Store, what_a_killed_process_left_is_removed) {
    fs::create_directory(folder + "/store");
    std::ofstream(folder + "/store/.anatomesh-incoming-3.tmp") << "half";
    std::ofstream(folder + "/store/notes.txt") << "mine";
    ObjectStore store = open();
    EXPECT_EQ(files(), std::vector<std::string>{"notes.txt"});
}

TEST_F(Store, a_link_in_the_place_of_a_folder_is_not_followed) {
    fs::create_directories(folder + "/store");
    fs::create_directories(folder + "/elsewhere");
    fs::create_directory_symlink(folder + "/elsewhere", folder + "/store/1.2.3");
    ObjectStore store = open();
    EXPECT_EQ(put(store, "1.2.5", data_set("1.2.5")).status, dimse::out_of_resources);
    EXPECT_TRUE(fs::is_empty(folder + "/elsewhere"));
}

TEST(Identify, images_that_contours_refer_to) {
    DicomWriter writer(DicomWriter::Syntax::implicit_little);
    writer.element(tags::sop_class, "UI", rtstruct_class);
    writer.element(tags::sop_instance, "UI", "1.5");
    writer.element(tags::study_instance, "UI", "1.2");
    writer.element(tags::series_instance, "UI", "1.3");
    writer.begin_sequence(tags::roi_contour_sequence);
    writer.begin_item();
    writer.begin_sequence(tags::contour_sequence);
    for (const char* uid : {"1.9", "1.8", "1.9"}) {
        writer.begin_item();
        writer.begin_sequence(tags::contour_image_sequence);
        writer.begin_item();
        writer.element(tags::referenced_sop_class, "UI", ct_class);
        writer.element(tags::referenced_sop_instance, "UI", uid);
        writer.end_item();
        writer.end_sequence();
        writer.end_item();
    }
    writer.end_sequence();
    writer.end_item();
    writer.end_sequence();
    const auto identity = identify_object(writer.file(rtstruct_class, "1.5"), "file");
    ASSERT_TRUE(identity.ok());
    EXPECT_EQ(identity.value().references, (std::vector<std::string>{"1.8", "1.9"}));
}

TEST(Transcode, explicit_to_implicit_keeps_the_elements) {
    const std::string file = meta_header({ct_class, "1.2.5", explicit_little_syntax}) + data_set("1.2.5");
    const auto converted = implicit_data_set(file);
    ASSERT_TRUE(converted);
    const auto identity =
        identify_object(meta_header({ct_class, "1.2.5", implicit_little_syntax}) + *converted, "file");
    ASSERT_TRUE(identity.ok());
    EXPECT_EQ(identity.value().sop_instance, "1.2.5");
}

}  // namespace
}  // namespace anatomesh::object_store_test
