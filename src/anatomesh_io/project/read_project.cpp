#include "anatomesh_io/project/read_project.h"

#include <optional>
#include <utility>

#include "anatomesh/base/plural.h"
#include "anatomesh_io/file/atomic_file.h"
#include "anatomesh_io/file/byte_reader.h"
#include "anatomesh_io/project/read_record.h"
#include "anatomesh_io/project/record_line.h"

namespace anatomesh {

namespace {

// Adds the place of a record to its error, and how to get at what is before it.
Error at_record(Error error, const std::string& path, std::uint64_t number, std::uint64_t byte) {
    error.place.file = path;
    error.place.value = "record " + std::to_string(number) + ", byte " + std::to_string(byte);
    if (error.next_step.empty() && number > 0)
        error.next_step = counted(number, "record") + " before it can be read: anatomesh project " + path +
                          " --recover OUT saves them";
    return error;
}

Error damaged(const std::string& path, std::uint64_t number, std::uint64_t byte) {
    return at_record(
        {ErrorKind::input, "E-PRJ-003", "a record is damaged: its length or its checksum is wrong", {}, {}},
        path, number, byte);
}

class Replay {
  public:
    Replay(const std::string& path, const ReadProjectOptions& options)
        : path_(path), points_left_(options.limits.points) {}

    // Reads the next record. What is refused leaves the project as it was.
    Status read(std::string_view record) {
        const std::uint64_t byte = project_.whole_bytes;
        Status status = project_.records == 0 ? read_first(record) : read_move(record);
        if (!status.ok()) return at_record(std::move(status).error(), path_, project_.records, byte);
        ++project_.records;
        project_.whole_bytes += record_line_bytes(record);
        return Nothing{};
    }

    Project& project() { return project_; }

  private:
    Status read_first(std::string_view record) {
        ANATOMESH_TRY(const DrawingSource source, read_head(record));
        project_.history = EditHistory(Drawing(source));
        return Nothing{};
    }

    Status read_move(std::string_view text) {
        EditHistory& history = project_.history;
        ANATOMESH_TRY(ProjectRecord record,
                      read_record(text, project_.records, history.drawing(), points_left_));
        if (record.move == ProjectRecord::Move::apply) {
            // That rings do not cross was seen when they were drawn, and the checksum says that they are the same.
            Status status = history.apply(std::move(record.edit), {}, CrossingCheck::no);
            if (status.ok()) return status;
            return contradiction(to_line(status.error()));
        }
        const bool is_undo = record.move == ProjectRecord::Move::undo;
        const auto steps = is_undo ? history.done() : history.undone();
        if (steps.empty())
            return contradiction(is_undo ? "there is nothing to undo" : "there is nothing to redo");
        if (steps.back().name != record.edit.name) return contradiction("the step has another name");
        const Result<bool> moved = is_undo ? history.undo() : history.redo();
        if (!moved.ok()) return moved.error();
        return Nothing{};
    }

    static Error contradiction(const std::string& why) {
        return {ErrorKind::input, "E-PRJ-004", "a record does not fit to those before it: " + why, {}, {}};
    }

    const std::string& path_;
    std::uint64_t points_left_;
    Project project_;
};

}  // namespace

Result<Project> replay_project(std::string_view text, const std::string& path,
                               const ReadProjectOptions& options, RunContext& context) {
    const RecordScan scan = scan_records(text);
    if (scan.records.empty())
        return Error{ErrorKind::input,
                     "E-PRJ-001",
                     "the file is no project of anatomesh",
                     {path, "", "", "", ""},
                     "give a project file"};
    Replay replay(path, options);
    std::optional<Error> failure;
    for (const std::string_view record : scan.records) {
        if (context.cancelled()) return cancelled_error();
        Status status = replay.read(record);
        if (status.ok()) continue;
        failure = std::move(status).error();
        break;
    }
    Project& project = replay.project();
    if (!failure && scan.end == RecordScan::End::damaged)
        failure = damaged(path, project.records, scan.whole_bytes);
    const bool is_damage = failure && failure->kind != ErrorKind::limit;
    if (failure && (!options.readable_part || !is_damage || project.records == 0)) return *std::move(failure);
    project.is_cut = project.whole_bytes < text.size();
    if (failure) {
        context.warn(
            {"W-PRJ-002", "a record cannot be read: " + failure->message, failure->place,
             "it and all behind it were left out; " + counted(project.records, "record") + " were read"});
    } else if (scan.end == RecordScan::End::torn) {
        context.warn({"W-PRJ-001",
                      "the last record was not written to its end, as when the power fails",
                      {path, "", "", "", "byte " + std::to_string(scan.whole_bytes)},
                      "it was left out; nobody was told that it was kept"});
    }
    return std::move(project);
}

Result<Project> read_project(const std::string& path, const ReadProjectOptions& options,
                             RunContext& context) {
    ANATOMESH_TRY(const InputFile file, read_input_file(path, options.limits.file));
    return replay_project(as_text(file.bytes()), path, options, context);
}

Result<Project> save_readable_part(const std::string& path, const std::string& output,
                                   const ProjectLimits& limits, RunContext& context) {
    ANATOMESH_TRY(const InputFile file, read_input_file(path, limits.file));
    const std::string_view text = as_text(file.bytes());
    ANATOMESH_TRY(Project project, replay_project(text, path, {limits, true}, context));
    ANATOMESH_CHECK_STATUS(write_file_atomically(output, text.substr(0, project.whole_bytes)));
    return project;
}

}  // namespace anatomesh
