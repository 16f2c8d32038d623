// ObjectStore: a folder of received DICOM objects: STUDY/SERIES/INSTANCE.dcm.
//
// An object goes to a temporary file in the folder, is synced, checked and renamed to its place, and the
// folders are synced; only then it counts as stored. Names from outside never become paths: folders and files
// are called by UIDs that are checked to be digits and points, and what is no UID by a hash of it. One
// process at a time may have a folder; what a killed one left is removed. Not thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh_io/file/system_calls.h"
#include "anatomesh_io/network/acceptor.h"

namespace anatomesh {

struct ObjectStoreOptions {
    std::uint64_t quota_bytes = 0;  // of all objects in the folder; 0: none
    std::uint64_t max_object_bytes = std::uint64_t{8} << 30;
};

// What a DICOM object says it is, and the images it refers to (of RTSTRUCT and SEG alone).
struct ObjectIdentity {
    std::string sop_class, sop_instance, study, series;
    std::vector<std::string> references;  // sorted, each once
};

// Reads the identity from a DICOM file. The layout is checked as a whole. Errors: E-DCL-*.
Result<ObjectIdentity> identify_object(std::string_view file, const std::string& name);

// What a store takes: objects of this study, series and instance. Empty: of any.
struct ObjectFilter {
    std::string study, series, instance;
    bool takes(const ObjectIdentity& identity) const;
};

// `unasked`: refused, because the filter of the store does not take it.
enum class StoreEnd : std::uint8_t { stored, there_already, refused, unasked };

// How an object ended.
struct StoreOutcome {
    StoreEnd end = StoreEnd::refused;
    std::uint16_t status = 0;  // of the C-STORE
    std::string reason;        // why it was refused; no UID, no name
    ObjectIdentity identity;   // as far as it is known
    std::string path;          // of the file, within the folder
    std::uint64_t bytes = 0;
};

class ObjectStore {
  public:
    // Makes the folder when it is missing (not those above it) and locks it. What it made and left empty goes
    // with it. Errors (file): E-NET-001 it
    // cannot be made or used, E-NET-002 another process receives into it.
    static Result<ObjectStore> open(const std::string& folder, const ObjectStoreOptions& options,
                                    SystemCalls& calls = SystemCalls::real());

    ObjectStore(ObjectStore&& other) noexcept;
    ObjectStore& operator=(ObjectStore&&) = delete;
    ~ObjectStore();

    const std::string& folder() const { return folder_; }
    std::uint64_t used_bytes() const { return used_; }
    // From now on.
    void take_only(ObjectFilter filter) { filter_ = std::move(filter); }

    // An object on its way in. Removed with the object unless finish() stored it.
    class Incoming {
      public:
        Incoming(ObjectStore& store, ObjectLabel label);
        Incoming(const Incoming&) = delete;
        Incoming& operator=(const Incoming&) = delete;
        ~Incoming();

        // A data set without a meta header, which is made from the label.
        void begin_data_set();
        void write(std::string_view bytes);
        // Checks and places the object. An object that is there already with the same content is success;
        // with other content it is refused. What has its name and cannot be read and compared refuses it too
        // (a file without permission, a link, no descriptor or memory left). What is there always stays. Success means
        // that the object and its names are on the disk.
        StoreOutcome finish();

      private:
        StoreOutcome refused(std::uint16_t status, std::string reason);
        StoreOutcome place(ObjectIdentity identity);
        StoreOutcome compare_with(const std::string& target, const std::string& study,
                                  const std::string& series, StoreOutcome outcome);

        ObjectStore* store_;
        ObjectLabel label_;  // empty fields: not stated
        std::string temporary_;
        int descriptor_ = -1;
        std::uint64_t bytes_ = 0;
        std::uint16_t failure_ = 0;
        std::string reason_;
    };

  private:
    ObjectStore(std::string folder, const ObjectStoreOptions& options, SystemCalls& calls)
        : folder_(std::move(folder)), options_(options), calls_(&calls) {}

    // Syncs the names on the way to an object, so that all of them are on the disk. Who made the folders plays no part: a killed
    // process may have made them and not synced them. Returns 0, or the errno.
    int sync_names(const std::string& study, const std::string& series);

    std::string folder_;
    ObjectStoreOptions options_;
    ObjectFilter filter_;
    SystemCalls* calls_;
    int lock_ = -1;
    bool made_ = false;  // the folder
    // The last ones whose names in the folders above are on the disk: objects come series by series.
    std::string synced_study_, synced_series_;
    bool is_folder_synced_ = false;  // its name in the one above
    std::uint64_t used_ = 0, number_ = 0;
};

// The name of a folder or file for a UID: the UID, or a hash of what is none.
std::string safe_name(std::string_view uid);

// The meta header of a file: preamble, DICM, group 2.
std::string meta_header(const ObjectLabel& label);

// A regular file mapped into memory, read only.
class MappedFile {
  public:
    enum class Links : std::uint8_t { refused, followed };
    explicit MappedFile(const std::string& path, Links links = Links::refused,
                        SystemCalls& calls = SystemCalls::real());
    MappedFile(const MappedFile&) = delete;
    MappedFile& operator=(const MappedFile&) = delete;
    ~MappedFile();
    bool is_open() const { return is_open_; }
    std::string_view bytes() const { return {data_, size_}; }
    // Why it is not open.
    const std::string& reason() const { return reason_; }

  private:
    const char* data_ = nullptr;
    std::size_t size_ = 0;
    bool is_open_ = false;
    std::string reason_;
};

}  // namespace anatomesh
