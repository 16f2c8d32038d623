#include "anatomesh_io/network/object_store.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "anatomesh_io/contour/dcmtk_set_up.h"
#include "anatomesh_io/contour/dicom_layout.h"
#include "anatomesh_io/contour/dicom_text.h"
#include "anatomesh_io/dicom/dicom_writer.h"
#include "anatomesh_io/dicom/sha256.h"
#include "anatomesh_io/dicom/tags.h"
#include "anatomesh_io/file/durable_calls.h"
#include "anatomesh_io/file/uninterrupted.h"
#include "anatomesh_io/network/dcmtk_door.h"

namespace anatomesh {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view temporary_prefix = ".anatomesh-incoming-";
constexpr std::string_view storage_class_prefix = "1.2.840.10008.5.1.4.1.1.";
// No more references of an object are kept, so that a hostile object takes no memory. [references; >= 1; B]
constexpr std::size_t most_references = 1'000'000;

// Keeps who an object is and which images it refers to.
class IdentityEvents : public DicomEvents {
  public:
    IdentityEvents(std::string_view file, ObjectIdentity& identity) : file_(file), identity_(identity) {}

    void element(DicomTag tag, std::string_view, std::size_t offset, std::size_t length) override {
        // The longest value that is looked at is a UID; a longer one is none. Offsets in a data set that was
        // inflated are none in the file.
        if (length > 1024 || offset > file_.size() || length > file_.size() - offset) return;
        const std::string_view value = without_padding(file_.substr(offset, length));
        if (depth_ == 0) return own_element(tag, value);
        if (tag == tags::referenced_sop_class) referenced_class_ = value;
        if (tag != tags::referenced_sop_instance || identity_.references.size() == most_references) return;
        // Studies and series are referred to by the same element.
        const bool refers =
            identity_.sop_class == rtstruct_class || identity_.sop_class == segmentation_class;
        if (refers && referenced_class_.starts_with(storage_class_prefix) && is_uid(value))
            identity_.references.emplace_back(value);
    }
    void begin(DicomTag, std::size_t) override { ++depth_; }
    void end() override { --depth_; }

  private:
    void own_element(DicomTag tag, std::string_view value) {
        if (tag == tags::sop_class) identity_.sop_class = value;
        if (tag == tags::sop_instance) identity_.sop_instance = value;
        if (tag == tags::study_instance) identity_.study = value;
        if (tag == tags::series_instance) identity_.series = value;
    }

    std::string_view file_, referenced_class_;
    ObjectIdentity& identity_;
    int depth_ = 0;
};

Error store_error(const char* code, const std::string& folder, std::string message, std::string next_step) {
    return {ErrorKind::file, code, std::move(message), {folder, "", "", "", ""}, std::move(next_step)};
}

// Makes the folder `path` unless it is there. False: it cannot be, or something else has its name.
bool make_folder(const std::string& path, bool& made) {
    made = ::mkdir(path.c_str(), 0777) == 0;
    if (made) return true;
    struct stat state {};
    return errno == EEXIST && ::lstat(path.c_str(), &state) == 0 && S_ISDIR(state.st_mode);
}

// Whether nothing has the name. What cannot be looked at counts as something.
bool is_free(const std::string& path) {
    struct stat state {};
    return ::lstat(path.c_str(), &state) != 0 && errno == ENOENT;
}

// Removes what killed processes left, and adds up the rest.
std::uint64_t take_stock(const std::string& folder, SystemCalls& calls) {
    std::error_code error;
    std::vector<std::string> stale;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
        const std::string name = at->path().filename().string();
        if (name.starts_with(temporary_prefix) && name.ends_with(".tmp"))
            stale.push_back(at->path().string());
    }
    for (const std::string& path : stale) calls.unlink(path.c_str());
    std::uint64_t bytes = 0;
    for (fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied, error),
         end;
         !error && at != end; at.increment(error)) {
        std::error_code unknown;
        if (at->is_regular_file(unknown) && !at->is_symlink(unknown)) {
            const std::uint64_t size = at->file_size(unknown);
            if (!unknown) bytes += size;
        }
    }
    return bytes;
}

}  // namespace

Result<ObjectIdentity> identify_object(std::string_view file, const std::string& name) {
    ObjectIdentity identity;
    IdentityEvents events(file, identity);
    // A deflated data set would have to be inflated into memory: its elements are not looked at.
    ANATOMESH_TRY(const DicomLayout layout, check_dicom_layout(file, name, is_sequence_tag, {}, &events));
    if (!layout.inflated.empty()) identity = {};
    std::sort(identity.references.begin(), identity.references.end());
    identity.references.erase(std::unique(identity.references.begin(), identity.references.end()),
                              identity.references.end());
    return identity;
}

bool ObjectFilter::takes(const ObjectIdentity& identity) const {
    return (study.empty() || study == identity.study) && (series.empty() || series == identity.series) &&
           (instance.empty() || instance == identity.sop_instance);
}

std::string safe_name(std::string_view uid) {
    return is_uid(uid) ? std::string(uid) : "x" + sha256_text(uid).substr(0, 40);
}

std::string meta_header(const ObjectLabel& label) {
    DicomWriter meta(DicomWriter::Syntax::explicit_little), length(DicomWriter::Syntax::explicit_little);
    meta.element({0x0002, 0x0001}, "OB", std::string_view("\0\1", 2));
    meta.element(tags::media_sop_class, "UI", label.sop_class);
    meta.element(tags::media_sop_instance, "UI", label.sop_instance);
    meta.element(tags::transfer_syntax, "UI", label.transfer_syntax);
    meta.element(tags::implementation_class, "UI", implementation_class_uid);
    meta.element(tags::implementation_version, "SH", "ANATOMESH");
    length.unsigned_long({0x0002, 0x0000}, {static_cast<std::uint32_t>(meta.bytes().size())});
    return std::string(128, '\0') + "DICM" + length.bytes() + meta.bytes();
}

Result<ObjectStore> ObjectStore::open(const std::string& folder, const ObjectStoreOptions& options,
                                      SystemCalls& calls) {
    ObjectStore store(folder, options, calls);
    struct stat state {};
    // A link to a folder is fine for the folder itself: the user has named it.
    if (!make_folder(folder, store.made_) && !(::stat(folder.c_str(), &state) == 0 && S_ISDIR(state.st_mode)))
        return store_error("E-NET-001", folder,
                           std::string("the folder cannot be created: ") + std::strerror(errno),
                           "give a folder inside an existing folder");
    if (::access(folder.c_str(), W_OK | X_OK) != 0)
        return store_error("E-NET-001", folder, "the folder cannot be written",
                           "check the permissions of the folder");
    store.lock_ = uninterrupted([&] { return ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); });
    if (store.lock_ < 0)
        return store_error("E-NET-001", folder,
                           std::string("the folder cannot be opened: ") + std::strerror(errno),
                           "check its permissions");
    if (::flock(store.lock_, LOCK_EX | LOCK_NB) != 0)
        return store_error("E-NET-002", folder, "another process receives into this folder",
                           "end that process, or choose another folder");
    store.used_ = take_stock(folder, calls);
    return store;
}

ObjectStore::ObjectStore(ObjectStore&& other) noexcept
    : folder_(std::move(other.folder_)),
      options_(other.options_),
      filter_(std::move(other.filter_)),
      calls_(other.calls_),
      lock_(std::exchange(other.lock_, -1)),
      made_(std::exchange(other.made_, false)),
      used_(other.used_),
      number_(other.number_) {}

ObjectStore::~ObjectStore() {
    if (made_) ::rmdir(folder_.c_str());  // fails when something is in it
    if (lock_ >= 0) ::close(lock_);
}

int ObjectStore::sync_names(const std::string& study, const std::string& series) {
    const std::string root = folder_ + "/";
    if (const int why = sync_folder(root + series, *calls_); why != 0) return why;
    if (series != synced_series_) {
        if (const int why = sync_folder(root + study, *calls_); why != 0) return why;
        synced_series_ = series;
    }
    if (study != synced_study_) {
        if (const int why = sync_folder(folder_, *calls_); why != 0) return why;
        synced_study_ = study;
    }
    if (!is_folder_synced_) {
        // The folder above may be one that this user cannot read, where nothing more can be done.
        if (const int why = sync_folder(folder_ + "/..", *calls_); why != 0 && why != EACCES) return why;
        is_folder_synced_ = true;
    }
    return 0;
}

ObjectStore::Incoming::Incoming(ObjectStore& store, ObjectLabel label)
    : store_(&store), label_(std::move(label)) {
    temporary_ =
        store.folder_ + "/" + std::string(temporary_prefix) + std::to_string(++store.number_) + ".tmp";
    const ObjectStoreOptions& options = store.options_;
    if (options.quota_bytes > 0 && store.used_ >= options.quota_bytes) {
        failure_ = dimse::out_of_resources;
        reason_ = "the quota is used up";
        return;
    }
    descriptor_ =
        store.calls_->open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (descriptor_ < 0) {
        failure_ = dimse::out_of_resources;
        reason_ = std::string("no file can be made: ") + std::strerror(errno);
    }
}

ObjectStore::Incoming::~Incoming() {
    if (descriptor_ < 0) return;
    store_->calls_->close(descriptor_);
    store_->calls_->unlink(temporary_.c_str());
}

void ObjectStore::Incoming::begin_data_set() {
    write(meta_header(label_));
}

void ObjectStore::Incoming::write(std::string_view bytes) {
    const ObjectStoreOptions& options = store_->options_;
    if (failure_ != 0) return;
    if (options.quota_bytes > 0 && bytes_ + bytes.size() > options.quota_bytes - store_->used_) {
        failure_ = dimse::out_of_resources;
        reason_ = "it would exceed the quota";
    } else if (bytes.size() > options.max_object_bytes - bytes_) {
        failure_ = dimse::out_of_resources;
        reason_ = "it is larger than an object may be";
    }
    while (failure_ == 0 && !bytes.empty()) {
        const ssize_t written = store_->calls_->write(descriptor_, bytes.data(), bytes.size());
        if (written < 0) {
            if (errno == EINTR) continue;
            failure_ = dimse::out_of_resources;
            reason_ = std::string("it cannot be written: ") + std::strerror(errno);
            break;
        }
        bytes.remove_prefix(static_cast<std::size_t>(written));
        bytes_ += static_cast<std::uint64_t>(written);
    }
    // What will not be stored need not take room until its end has come.
    if (failure_ != 0 && descriptor_ >= 0) static_cast<void>(::ftruncate(descriptor_, 0));
}

StoreOutcome ObjectStore::Incoming::refused(std::uint16_t status, std::string reason) {
    StoreOutcome outcome;
    outcome.status = status;
    outcome.reason = std::move(reason);
    outcome.bytes = bytes_;
    return outcome;
}

StoreOutcome ObjectStore::Incoming::finish() {
    if (failure_ != 0) return refused(failure_, reason_);
    if (store_->calls_->fsync(descriptor_) != 0)
        return refused(dimse::out_of_resources, std::string("it cannot be synced: ") + std::strerror(errno));
    ObjectIdentity identity;
    {
        const MappedFile file(temporary_, MappedFile::Links::refused, *store_->calls_);
        if (!file.is_open())
            return refused(dimse::out_of_resources, "it cannot be read back: " + file.reason());
        auto found = identify_object(file.bytes(), "the object");
        if (!found.ok()) return refused(dimse::cannot_understand, found.error().message);
        identity = std::move(found).value();
    }
    if (!label_.sop_instance.empty() &&
        (identity.sop_instance != label_.sop_instance || identity.sop_class != label_.sop_class))
        return refused(dimse::does_not_match_class, "its data set is of another object than was said");
    if (identity.sop_instance.empty() || identity.study.empty() || identity.series.empty() ||
        !is_storage_class(identity.sop_class))
        return refused(dimse::cannot_understand, "it does not say its class, instance, series and study");
    if (!store_->filter_.takes(identity)) {
        StoreOutcome outcome = refused(dimse::not_authorized, "it was not asked for: its UIDs are others");
        outcome.end = StoreEnd::unasked;
        return outcome;
    }
    return place(std::move(identity));
}

// An object whose name is taken. Only what is read and found equal counts as there, and nothing takes the place
// of what cannot be read: it may be the one object of this UID that somebody has planned with.
StoreOutcome ObjectStore::Incoming::compare_with(const std::string& target, const std::string& study,
                                                 const std::string& series, StoreOutcome outcome) {
    const MappedFile there(target, MappedFile::Links::refused, *store_->calls_);
    if (!there.is_open()) {
        outcome.status = dimse::unreadable_there;
        outcome.reason = "what is there under its UID cannot be read and compared: " + there.reason();
        return outcome;
    }
    const MappedFile made(temporary_, MappedFile::Links::refused, *store_->calls_);
    if (!made.is_open()) {
        outcome.status = dimse::out_of_resources;
        outcome.reason = "it cannot be read back: " + made.reason();
        return outcome;
    }
    const bool equal = there.bytes() == made.bytes();
    outcome.end = equal ? StoreEnd::there_already : StoreEnd::refused;
    outcome.status = equal ? dimse::success : dimse::other_content;
    if (!equal) outcome.reason = "an object of the same UID with other content is there";
    // A process may have been killed between its name and the sync of it.
    if (const int why = equal ? store_->sync_names(study, series) : 0; why != 0) {
        outcome.end = StoreEnd::refused;
        outcome.status = dimse::out_of_resources;
        outcome.reason = std::string("its folder cannot be synced: ") + std::strerror(why);
    }
    return outcome;
}

StoreOutcome ObjectStore::Incoming::place(ObjectIdentity identity) {
    SystemCalls& calls = *store_->calls_;
    const std::string root = store_->folder_ + "/";
    const std::string study = safe_name(identity.study), series = study + "/" + safe_name(identity.series);
    StoreOutcome outcome;
    outcome.path = series + "/" + safe_name(identity.sop_instance) + ".dcm";
    outcome.identity = std::move(identity);
    outcome.bytes = bytes_;
    const std::string target = root + outcome.path;
    if (!is_free(target)) return compare_with(target, study, series, std::move(outcome));
    const auto fails = [&](const std::string& what) {
        outcome.status = dimse::out_of_resources;
        outcome.reason = what + ": " + std::strerror(errno);
        return outcome;
    };
    bool new_study = false, new_series = false;
    if (!make_folder(root + study, new_study) || !make_folder(root + series, new_series))
        return fails("no folder can be made for it");
    if (new_study) store_->synced_study_.clear();
    if (new_series) store_->synced_series_.clear();
    if (calls.rename(temporary_.c_str(), target.c_str()) != 0) return fails("it cannot be given its name");
    calls.close(std::exchange(descriptor_, -1));
    if (const int why = store_->sync_names(study, series); why != 0) {
        calls.unlink(target.c_str());
        errno = why;
        return fails("its folder cannot be synced");
    }
    store_->used_ += bytes_;
    outcome.end = StoreEnd::stored;
    outcome.status = dimse::success;
    return outcome;
}

MappedFile::MappedFile(const std::string& path, Links links, SystemCalls& calls) {
    const int follow = links == Links::followed ? 0 : O_NOFOLLOW;
    const int descriptor = uninterrupted(
        [&] { return calls.open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | follow, 0); });
    if (descriptor < 0) {
        reason_ = errno == ELOOP ? "it is a link" : std::strerror(errno);
        return;
    }
    struct stat state {};
    if (uninterrupted([&] { return ::fstat(descriptor, &state); }) != 0) {
        reason_ = std::strerror(errno);
    } else if (!S_ISREG(state.st_mode)) {
        reason_ = "it is no regular file";
    } else {
        const auto size = static_cast<std::size_t>(state.st_size);
        void* memory = size > 0 ? ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, descriptor, 0) : nullptr;
        if (memory != MAP_FAILED) {
            data_ = static_cast<const char*>(memory);
            size_ = size;
            is_open_ = true;
        } else {
            reason_ = std::strerror(errno);
        }
    }
    ::close(descriptor);
}

MappedFile::~MappedFile() {
    if (data_) ::munmap(const_cast<char*>(data_), size_);
}

}  // namespace anatomesh
