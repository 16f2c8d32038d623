#include "watch_studies.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>
#include <utility>

#include "anatomesh/base/plural.h"
#include "anatomesh_io/contour/number_text.h"
#include "anatomesh_io/dicom/folder.h"
#include "anatomesh_io/dicom/sha256.h"
#include "anatomesh_io/file/atomic_file.h"

namespace anatomesh {

namespace fs = std::filesystem;

namespace {

// Who is asked to end and does not is killed. [s; > 0; B]
constexpr double seconds_to_end = 2;
// Of the time of processes that are asked to end is asked as often. [ms; > 0; B]
constexpr std::chrono::milliseconds end_interval{20};

constexpr const char* models_folder = "models";
constexpr const char* failure_name = "failure.txt";
constexpr const char* model_name = "model.vtu";
constexpr const char* instances_name = "instances.sha256";  // which objects the version is of

// The versions there are, by their numbers.
std::map<std::uint32_t, fs::path> versions_in(const fs::path& folder) {
    std::map<std::uint32_t, fs::path> versions;
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
        if (const auto number = parse_integer<std::uint32_t>(at->path().filename().string());
            number && *number > 0)
            versions[*number] = at->path();
    return versions;
}

// Whether its process came to an end: a receiver that was killed leaves neither a model nor a reason.
bool is_finished(const fs::path& version) {
    std::error_code error;
    const auto size = fs::file_size(version / failure_name, error);
    return fs::exists(version / model_name, error) || (!error && size > 0);
}

std::string hash_of(const std::set<std::string>& instances) {
    std::string text;
    for (const std::string& uid : instances) text += uid + "\n";
    return sha256_text(text);
}

double seconds_since_then(std::chrono::steady_clock::time_point then) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - then).count();
}

// What a signal means that ended a process.
std::string text_of_signal(int number) {
    const std::string text = fmt::format("signal {} ended the process", number);
    if (number == SIGKILL) return text + ", as the system does when memory runs out";
    return text + ", which is a fault of the program: please report it with the study";
}

// Runs in the child, where nothing may be allocated.
[[noreturn]] void become(char* const* words, const char* failure) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    // Where memory ends, the system ends the model, not the receiver.
    const int badness = ::open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC);
    const char worst[] = "1000";
    static_cast<void>(!::write(badness, worst, sizeof worst - 1));
    const int null = ::open("/dev/null", O_RDWR);
    const int log = ::open(failure, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW, 0666);
    ::dup2(null, STDIN_FILENO);
    ::dup2(null, STDOUT_FILENO);
    ::dup2(log, STDERR_FILENO);
    const struct rlimit none { 0, 0 };
    ::setrlimit(RLIMIT_CORE, &none);
    ::setpriority(PRIO_PROCESS, 0, 10);
    ::execv("/proc/self/exe", words);
    ::_exit(127);
}

}  // namespace

StudyWatch::StudyWatch(std::string folder, const WatchOptions& options,
                       std::function<void(const std::string&)> say)
    : folder_(std::move(folder)), options_(options), say_(std::move(say)) {
    look_around();
}

StudyWatch::~StudyWatch() {
    end();
}

void StudyWatch::look_around() {
    std::error_code error;
    for (fs::directory_iterator at(folder_, error), none; !error && at != none; at.increment(error)) {
        const std::string name = at->path().filename().string();
        std::error_code ignored;
        if (name == models_folder || name.starts_with('.') || !at->is_directory(ignored)) continue;
        for (fs::recursive_directory_iterator file(at->path(), ignored), end; !ignored && file != end;
             file.increment(ignored)) {
            std::error_code unknown;
            if (file->path().extension() != ".dcm" || !file->is_regular_file(unknown)) continue;
            const MappedFile bytes(file->path().string());
            const auto identity = identify_object(bytes.bytes(), name);
            if (identity.ok()) add(name, identity.value());
        }
        const auto study = studies_.find(name);
        if (study == studies_.end()) continue;
        const std::string wanted = hash_of(study->second.instances);
        for (const auto& [number, version] : versions_in(fs::path(folder_) / models_folder / name)) {
            std::string made;
            std::ifstream(version / instances_name) >> made;
            if (!is_finished(version))
                fs::remove_all(version, ignored);
            else if (made == wanted)
                study->second.is_due = false;
        }
    }
}

void StudyWatch::add(const std::string& name, const ObjectIdentity& identity) {
    Study& study = studies_[name];
    study.last = Clock::now();
    study.instances.insert(identity.sop_instance);
    study.references.insert(identity.references.begin(), identity.references.end());
    study.has_structures = study.has_structures || identity.sop_class == rtstruct_class ||
                           identity.sop_class == segmentation_class;
    study.is_due = true;
    study.was_missed = false;
}

void StudyWatch::arrived(const StoreOutcome& outcome) {
    const std::string name = outcome.path.substr(0, outcome.path.find('/'));
    if (outcome.end == StoreEnd::stored)
        add(name, outcome.identity);
    else if (outcome.end == StoreEnd::there_already && studies_.contains(name))
        studies_[name].last = Clock::now();
}

std::size_t StudyWatch::missing(const Study& study) const {
    return static_cast<std::size_t>(
        std::count_if(study.references.begin(), study.references.end(),
                      [&](const std::string& uid) { return !study.instances.contains(uid); }));
}

void StudyWatch::tick(const std::vector<std::string>& busy) {
    check_time();
    reap();
    start_next(busy);
}

void StudyWatch::check_time() {
    if (child_ < 0) return;
    if (!is_asked_ && seconds_since_then(child_begun_) > options_.model_seconds) {
        ::kill(child_, SIGTERM);
        is_asked_ = true;
        child_asked_ = Clock::now();
    } else if (is_asked_ && seconds_since_then(child_asked_) > seconds_to_end) {
        ::kill(child_, SIGKILL);
    }
}

void StudyWatch::start_next(const std::vector<std::string>& busy) {
    std::map<std::string, Study>::iterator next = studies_.end();
    for (auto at = studies_.begin(); at != studies_.end(); ++at) {
        const std::string& name = at->first;
        Study& study = at->second;
        if (!study.is_due || !study.has_structures) continue;
        const double quiet = seconds_since_then(study.last);
        if (quiet < options_.settle_seconds || std::find(busy.begin(), busy.end(), name) != busy.end())
            continue;
        if (const std::size_t count = missing(study); count > 0) {
            if (study.was_missed || quiet < options_.patience * options_.settle_seconds) continue;
            say_(fmt::format("study {}: no model yet, because {} that its structures refer to {} missing",
                             series_name(name), counted(count, "image"), count == 1 ? "is" : "are"));
            study.was_missed = true;
            continue;
        }
        if (next == studies_.end() || study.last < next->second.last) next = at;
    }
    if (child_ < 0 && next != studies_.end()) start(next->first, next->second);
}

void StudyWatch::start(const std::string& name, Study& study) {
    study.is_due = false;
    const fs::path models = fs::path(folder_) / models_folder / name;
    const auto versions = versions_in(models);
    const fs::path version = models / std::to_string(versions.empty() ? 1 : versions.rbegin()->first + 1);
    std::error_code error;
    fs::create_directories(version, error);
    const auto in_version = [&](const char* file) { return (version / file).string(); };
    const Status noted = write_file_atomically(in_version(instances_name), hash_of(study.instances) + "\n");
    if (error || !noted.ok()) {
        say_(fmt::format("study {}: no model, because its folder cannot be created: {}", series_name(name),
                         error ? error.message() : noted.error().message));
        return;
    }
    std::vector<std::string> words{"anatomesh",
                                   "model",
                                   (fs::path(folder_) / name).string(),
                                   "-o",
                                   in_version(model_name),
                                   "--surface",
                                   in_version("model.stl"),
                                   "--html",
                                   in_version("model.html"),
                                   "--dicom-surface",
                                   in_version("surface.dcm"),
                                   "--quiet"};
    if (options_.keep_patient_ids) words.emplace_back("--keep-patient-ids");
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    const std::string failure = in_version(failure_name);
    const pid_t child = ::fork();
    if (child == 0) become(pointers.data(), failure.c_str());
    if (child < 0) {
        say_(fmt::format("study {}: no model, because no process could be started", series_name(name)));
        study.is_due = true;
        study.last = Clock::now();
        return;
    }
    child_ = child;
    child_begun_ = Clock::now();
    is_asked_ = false;
    child_study_ = name;
    child_folder_ = version.string();
    say_(fmt::format("study {}: complete, making its model", series_name(name)));
}

void StudyWatch::reap() {
    int status = 0;
    if (child_ < 0 || ::waitpid(child_, &status, WNOHANG) != child_) return;
    child_ = -1;
    const std::string study = series_name(child_study_),
                      version = fs::path(child_folder_).filename().string();
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
        std::error_code ignored;
        fs::remove(fs::path(child_folder_) / failure_name, ignored);
        ++models_;
        say_(fmt::format("study {}: model {} made in {:.0f} s", study, version,
                         seconds_since_then(child_begun_)));
        return;
    }
    std::string reason;
    if (is_asked_)
        reason = fmt::format("it took longer than {:g} s and was ended; --model-time allows more",
                             options_.model_seconds);
    else if (WIFSIGNALED(status))
        reason = text_of_signal(WTERMSIG(status));
    note_failure(reason);
    if (reason.empty()) reason = fmt::format("exit code {}", WEXITSTATUS(status));
    say_(fmt::format("study {}: no model {}: {}; its {} says why", study, version, reason, failure_name));
}

// Removes what a process left that was ended between its outputs, and adds the reason that it could not give
// itself.
void StudyWatch::note_failure(const std::string& reason) {
    const fs::path version = child_folder_;
    std::error_code ignored;
    std::vector<fs::path> left;
    for (fs::directory_iterator at(version, ignored), none; !ignored && at != none; at.increment(ignored))
        if (const fs::path name = at->path().filename(); name != failure_name && name != instances_name)
            left.push_back(at->path());
    for (const fs::path& path : left) fs::remove(path, ignored);
    if (reason.empty()) return;
    std::ifstream file(version / failure_name);
    std::string text{std::istreambuf_iterator<char>(file), {}};
    text += fmt::format("anatomesh: {}\n", reason);
    const Status noted = write_file_atomically((version / failure_name).string(), text);
    if (!noted.ok()) say_(fmt::format("{} cannot be written: {}", failure_name, noted.error().message));
}

void StudyWatch::end() {
    if (child_ < 0) return;
    ::kill(child_, SIGTERM);
    const Clock::time_point asked = Clock::now();
    while (::waitpid(child_, nullptr, WNOHANG) == 0) {
        if (seconds_since_then(asked) > seconds_to_end) ::kill(child_, SIGKILL);
        std::this_thread::sleep_for(end_interval);
    }
    child_ = -1;
    // So that the next run makes up for it.
    std::error_code ignored;
    fs::remove_all(child_folder_, ignored);
}

}  // namespace anatomesh
