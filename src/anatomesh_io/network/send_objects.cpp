#include "anatomesh_io/network/send_objects.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "anatomesh_io/contour/dcmtk_set_up.h"
#include "anatomesh_io/contour/dicom_layout.h"
#include "anatomesh_io/file/input_file.h"
#include "anatomesh_io/network/dcmtk_door.h"
#include "anatomesh_io/network/stow.h"

namespace anatomesh {

namespace fs = std::filesystem;

namespace {

// An association carries so many pairs of class and syntax: each takes two of its 128 contexts.
// [pairs; 1 to 64; D DICOM PS3.8, section 9.3]
constexpr std::size_t most_pairs = 64;

Error input_error(const char* code, const std::string& path, std::string message, std::string next_step) {
    return {ErrorKind::input, code, std::move(message), {path, "", "", "", ""}, std::move(next_step)};
}

// Nothing: no DICOM file.
Result<std::optional<OutgoingObject>> look_at(const std::string& path) {
    const MappedFile file(path, MappedFile::Links::followed);
    if (!file.is_open()) return std::optional<OutgoingObject>{};
    const bool may_lack_meta =
        file.bytes().size() > 8 && file.bytes().substr(0, 2) == std::string_view("\x08\0", 2);
    if (!is_dicom(file.bytes()) && !may_lack_meta) return std::optional<OutgoingObject>{};
    OutgoingObject object;
    object.path = path;
    ANATOMESH_TRY(const DicomLayout layout, check_dicom_layout(file.bytes(), path, is_sequence_tag));
    ANATOMESH_TRY(object.identity, identify_object(file.bytes(), path));
    object.transfer_syntax = layout.transfer_syntax;
    object.data_set = layout.data_set;
    object.has_meta = layout.has_meta;
    object.bytes = file.bytes().size();
    const ObjectIdentity& identity = object.identity;
    // A DICOMDIR is no object of a study.
    if (identity.sop_class.empty() || identity.sop_instance.empty()) return std::optional<OutgoingObject>{};
    if (!is_uid(identity.sop_class) || !is_uid(identity.sop_instance))
        return input_error("E-NET-007", path, "the object has no valid SOP class and instance UID",
                           "export the file again");
    return std::optional<OutgoingObject>(std::move(object));
}

Result<std::vector<std::string>> files_in(const std::string& folder) {
    std::vector<std::string> paths;
    std::error_code error;
    for (fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied, error),
         end;
         !error && at != end; at.increment(error)) {
        std::error_code unknown;
        if (at->is_regular_file(unknown) && !at->is_symlink(unknown)) paths.push_back(at->path().string());
    }
    if (error)
        return input_error("E-NET-006", folder, "the folder cannot be read: " + error.message(),
                           "check the permissions of the folder");
    std::sort(paths.begin(), paths.end());
    return paths;
}

using Pair = std::pair<std::string, std::string>;  // class, syntax

Pair pair_of(const OutgoingObject& object) {
    return {object.identity.sop_class, object.transfer_syntax};
}

// Objects of at most so many pairs, in the order given.
std::vector<std::vector<std::uint32_t>> batches_of(const std::vector<OutgoingObject>& objects) {
    std::vector<std::vector<std::uint32_t>> batches(1);
    std::set<Pair> pairs;
    for (std::uint32_t i = 0; i < objects.size(); ++i) {
        const Pair pair = pair_of(objects[i]);
        if (!pairs.contains(pair) && pairs.size() == most_pairs) {
            pairs.clear();
            batches.emplace_back();
        }
        pairs.insert(pair);
        batches.back().push_back(i);
    }
    return batches;
}

std::vector<PresentationContext> contexts_for(const std::vector<OutgoingObject>& objects,
                                              const std::vector<std::uint32_t>& batch) {
    std::set<Pair> pairs;
    for (const std::uint32_t i : batch) {
        pairs.insert(pair_of(objects[i]));
        if (objects[i].transfer_syntax == explicit_little_syntax ||
            objects[i].transfer_syntax == explicit_big_syntax)
            pairs.insert({objects[i].identity.sop_class, implicit_little_syntax});
    }
    std::vector<PresentationContext> contexts;
    for (const auto& [sop_class, syntax] : pairs)
        contexts.push_back({0, sop_class, {syntax}, context_accepted});
    return contexts;
}

Result<SentObject> send_one(Requestor& requestor, const OutgoingObject& object, std::uint32_t index) {
    SentObject sent{index, 0, {}};
    const MappedFile file(object.path, MappedFile::Links::followed);
    if (file.bytes().size() != object.bytes)
        return input_error("E-NET-008", object.path, "the file changed while it was sent", "send again");
    const PresentationContext* context =
        requestor.context_of(object.identity.sop_class, object.transfer_syntax);
    std::optional<std::string> converted;
    if (!context) {
        context = requestor.context_of(object.identity.sop_class, implicit_little_syntax);
        if (context) converted = implicit_data_set(file.bytes());
        if (!converted) {
            sent.reason = context ? "it cannot be put into a transfer syntax that the peer takes"
                                  : "the peer takes no objects of this class and transfer syntax";
            return sent;
        }
    }
    const std::string_view data =
        converted ? std::string_view(*converted) : file.bytes().substr(object.data_set);
    ANATOMESH_TRY(sent.status, requestor.store(*context, object.identity.sop_instance, data));
    // 0xBxxx: stored, with a warning.
    if (sent.status != dimse::success && sent.status >> 12 != 0xB) sent.reason = text_of_status(sent.status);
    return sent;
}

Result<SendResult> send_dicom(const std::vector<OutgoingObject>& objects, const ConnectOptions& options,
                              const RunContext& context) {
    RequestorOptions connecting{*options.peer.dicom, options.title, options.timeout_seconds, nullptr,
                                options.limits};
    std::optional<TlsContext> tls;
    if (options.use_tls) {
        ANATOMESH_TRY(tls, TlsContext::client(options.tls));
        connecting.tls = &*tls;
    }
    SendResult result;
    for (const std::vector<std::uint32_t>& batch : batches_of(objects)) {
        ANATOMESH_TRY(Requestor requestor,
                      Requestor::associate(connecting, contexts_for(objects, batch), {}, context));
        for (const std::uint32_t index : batch) {
            ANATOMESH_TRY(SentObject sent, send_one(requestor, objects[index], index));
            if (sent.is_stored()) {
                ++result.stored;
                result.bytes += objects[index].bytes;
            }
            result.objects.push_back(std::move(sent));
            context.report("send",
                           static_cast<double>(result.objects.size()) / static_cast<double>(objects.size()));
        }
        requestor.release();
    }
    return result;
}

}  // namespace

Result<std::vector<OutgoingObject>> find_objects(const std::vector<std::string>& paths,
                                                 std::uint64_t& skipped, RunContext& context) {
    std::vector<OutgoingObject> objects;
    skipped = 0;
    for (const std::string& path : paths) {
        std::error_code error;
        const bool is_folder = fs::is_directory(path, error);
        std::vector<std::string> files{path};
        if (is_folder) {
            ANATOMESH_TRY(files, files_in(path));
        } else {
            // Says why a file cannot be read.
            ANATOMESH_TRY(const std::vector<std::byte> start, read_input_start(path, 1));
        }
        for (const std::string& file : files) {
            if (context.cancelled()) return cancelled_error();
            ANATOMESH_TRY(std::optional<OutgoingObject> object, look_at(file));
            if (object)
                objects.push_back(std::move(*object));
            else if (is_folder)
                ++skipped;
            else
                return input_error("E-NET-006", path,
                                   "the file is no DICOM object with an SOP class and instance UID",
                                   "name DICOM files, or folders of them");
        }
    }
    if (objects.empty())
        return input_error("E-NET-006", paths.empty() ? "" : paths.front(),
                           "no DICOM object with an SOP class and instance UID was found",
                           "name DICOM files, or folders of them");
    return objects;
}

Result<SendResult> send_objects(const std::vector<OutgoingObject>& objects, const ConnectOptions& options,
                                const RunContext& context) {
    return options.peer.dicom ? send_dicom(objects, options, context)
                              : stow_objects(objects, options, context);
}

std::string text_of_status(std::uint16_t status) {
    if (status >> 8 == 0xA7) return "the peer is out of resources";
    if (status >> 8 == 0xA9) return "the data set does not match its class";
    if (status == dimse::other_content) return "the peer has another object of this UID";
    if (status >> 12 == 0xC) return "the peer cannot understand the data set";
    if (status == 0x0122) return "the peer does not support the class";
    if (status == 0x0124) return "the peer does not allow it";
    if (status == dimse::no_such_operation) return "the peer does not know the operation";
    return "the peer failed";
}

}  // namespace anatomesh
