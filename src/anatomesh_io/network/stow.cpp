#include "anatomesh_io/network/stow.h"

#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "anatomesh_io/dicom/sha256.h"
#include "anatomesh_io/network/dicom_json.h"
#include "anatomesh_io/network/http_client.h"

namespace anatomesh {

namespace {

using Json = nlohmann::json;

// A request carries no more objects, so that a failure repeats few. [objects; >= 1; B]
constexpr std::size_t most_objects = 100;
// A request takes no further object from this size on. [bytes; > 0; B]
constexpr std::uint64_t most_bytes = std::uint64_t{64} << 20;
constexpr const char* dicom_json = "application/dicom+json";
// Where a server gives no reason, the object counts as not understood.
// [code; 0xC000; D DICOM PS3.4, section B.2.3]
constexpr std::size_t status_refused = 0xC000;

// The content of a request: for every object a head and its file, then an end. Only one file at a time is
// mapped.
class Content {
  public:
    Content(const std::vector<OutgoingObject>& objects, std::size_t first, std::size_t last,
            const std::string& boundary)
        : objects_(objects), first_(first), boundary_(boundary) {
        for (std::size_t i = first; i < last; ++i) {
            starts_.push_back(size_);
            size_ += head(i).size() + body_bytes(i);
        }
        starts_.push_back(size_);
        size_ += tail().size();
    }
    std::uint64_t size() const { return size_; }
    bool changed() const { return changed_.has_value(); }
    const std::string& changed_path() const { return *changed_; }

    std::string_view read(std::uint64_t offset, std::size_t most) {
        const auto after = std::upper_bound(starts_.begin(), starts_.end(), offset);
        const auto part = static_cast<std::size_t>(after - starts_.begin()) - 1;
        std::uint64_t within = offset - starts_[part];
        if (part + 1 == starts_.size()) {
            piece_ = tail();
            return std::string_view(piece_).substr(within, most);
        }
        const std::size_t index = first_ + part;
        piece_ = head(index);
        if (within < piece_.size()) return std::string_view(piece_).substr(within, most);
        within -= piece_.size();
        if (mapped_ != index) {
            file_ = std::make_unique<MappedFile>(objects_[index].path, MappedFile::Links::followed);
            mapped_ = index;
        }
        if (file_->bytes().size() != objects_[index].bytes) {
            changed_ = objects_[index].path;
            return {};
        }
        return file_->bytes().substr(within, most);
    }

  private:
    // The meta header that a file lacks belongs to the head.
    std::string head(std::size_t index) const {
        const OutgoingObject& object = objects_[index];
        std::string text =
            (index == first_ ? "--" : "\r\n--") + boundary_ + "\r\nContent-Type: application/dicom\r\n\r\n";
        if (!object.has_meta)
            text += meta_header(
                {object.identity.sop_class, object.identity.sop_instance, object.transfer_syntax});
        return text;
    }
    std::uint64_t body_bytes(std::size_t index) const { return objects_[index].bytes; }
    std::string tail() const { return "\r\n--" + boundary_ + "--\r\n"; }

    const std::vector<OutgoingObject>& objects_;
    std::size_t first_;
    std::string boundary_;
    std::vector<std::uint64_t> starts_;
    std::uint64_t size_ = 0;
    std::string piece_;
    std::unique_ptr<MappedFile> file_;
    std::size_t mapped_ = static_cast<std::size_t>(-1);
    std::optional<std::string> changed_;
};

// The instances that the answer lists under a sequence, with the reason that it gives.
std::map<std::string, std::uint16_t> listed(const Json& answer, const char* sequence) {
    std::map<std::string, std::uint16_t> instances;
    if (!answer.is_object() || !answer.contains(sequence)) return instances;
    const Json& element = answer[sequence];
    if (!element.is_object() || !element.contains("Value") || !element["Value"].is_array()) return instances;
    for (const Json& item : element["Value"]) {
        const std::string uid = json_text_of(item, {0x0008, 0x1155});
        const auto reason = json_number_of(item, {0x0008, 0x1197});
        if (!uid.empty()) instances[uid] = static_cast<std::uint16_t>(reason.value_or(status_refused));
    }
    return instances;
}

}  // namespace

Result<SendResult> stow_objects(const std::vector<OutgoingObject>& objects, const ConnectOptions& options,
                                const RunContext& context) {
    HttpClient client(options, context);
    SendResult result;
    for (std::size_t first = 0; first < objects.size();) {
        std::size_t last = first;
        std::string names;
        for (std::uint64_t bytes = 0;
             last < objects.size() && last - first < most_objects && bytes < most_bytes; ++last) {
            bytes += objects[last].bytes;
            names += objects[last].identity.sop_instance;
        }
        // A boundary that no file can hold by chance.
        const std::string boundary = "anatomesh-" + sha256_text(names).substr(0, 48);
        Content content(objects, first, last, boundary);
        std::string text;
        auto reply = client.post(
            "/studies", "multipart/related; type=\"application/dicom\"; boundary=" + boundary, dicom_json,
            content.size(),
            [&](std::uint64_t offset, std::size_t most) { return content.read(offset, most); }, text);
        if (content.changed())
            return Error{ErrorKind::input,
                         "E-NET-008",
                         "the file changed while it was sent",
                         {content.changed_path(), "", "", "", ""},
                         "send again"};
        if (!reply.ok()) return reply.error();
        const int status = reply.value().status;
        // 202: some were not stored; 409: none was.
        if (status != 200 && status != 202 && status != 409)
            return client.refused(reply.value(), "what is sent");
        ANATOMESH_TRY(const Json answer,
                      parse_dicom_json(text, reply.value().content_type, options.peer.url));
        const auto stored = listed(answer, "00081199"), failed = listed(answer, "00081198");
        for (std::size_t i = first; i < last; ++i) {
            const std::string& uid = objects[i].identity.sop_instance;
            SentObject sent{static_cast<std::uint32_t>(i), 0, {}};
            if (const auto why = failed.find(uid); why != failed.end()) {
                sent.status = why->second;
                sent.reason = text_of_status(sent.status);
            } else if (!stored.contains(uid)) {
                sent.status = status_refused;
                sent.reason = "the service does not say that it has it";
            }
            if (sent.is_stored()) {
                ++result.stored;
                result.bytes += objects[i].bytes;
            }
            result.objects.push_back(std::move(sent));
        }
        first = last;
        context.report("send", static_cast<double>(first) / static_cast<double>(objects.size()));
    }
    return result;
}

}  // namespace anatomesh
