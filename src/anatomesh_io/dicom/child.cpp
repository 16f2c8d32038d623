#include "anatomesh_io/dicom/child.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>
#include <exception>
#include <fstream>
#include <new>
#include <utility>

namespace anatomesh {

namespace {

// A child process hands over no more of the reason why it failed: the memory that both share is of a fixed
// size. [bytes; >= 1; B]
constexpr std::size_t longest_reason = 200;

// What the child tells its parent.
struct Progress {
    std::atomic<std::size_t> done;
    char reason[longest_reason + 1];
};

std::uint64_t address_space_now() {
    std::uint64_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

void limit(int resource, std::uint64_t value) {
    const struct rlimit both { value, value };
    ::setrlimit(static_cast<__rlimit_resource>(resource), &both);
}

void confine(const ChildLimits& limits) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    limit(RLIMIT_CORE, 0);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    limit(RLIMIT_AS, address_space_now() + limits.memory_bytes);
#endif
    for (const int number : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGINT, SIGTERM})
        ::signal(number, SIG_DFL);
    // What a decoder prints is nobody's business.
    const int null = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (null >= 0) {
        ::dup2(null, STDOUT_FILENO);
        ::dup2(null, STDERR_FILENO);
    }
}

[[noreturn]] void work(std::size_t count, const std::function<std::string(std::size_t)>& step,
                       const ChildLimits& limits, Progress& progress) {
    confine(limits);
    for (std::size_t i = 0; i < count; ++i) {
        std::string reason;
        ::alarm(2 * limits.seconds);
        try {
            reason = step(i);
        } catch (const std::bad_alloc&) {
            reason = "it needs more memory than the limit";
        } catch (const std::exception&) {
            reason = "the decoder failed";
        }
        if (!reason.empty()) {
            std::memcpy(progress.reason, reason.data(), std::min(reason.size(), longest_reason));
            ::_exit(1);
        }
        progress.done.store(i + 1, std::memory_order_release);
    }
    ::_exit(0);
}

std::string reason_of(int status, const Progress& progress) {
    if (WIFEXITED(status) && progress.reason[0]) return progress.reason;
    if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGALRM || WTERMSIG(status) == SIGXCPU))
        return "the decoder took too long";
    if (WIFSIGNALED(status)) return "the decoder was stopped by signal " + std::to_string(WTERMSIG(status));
    return "the decoder ended early";
}

}  // namespace

ChildResult run_in_child(std::size_t count, const std::function<std::string(std::size_t)>& step,
                         const ChildLimits& limits, const RunContext& context) {
    ChildResult result;
    const SharedBytes shared(sizeof(Progress));
    Progress* progress = shared.data() ? new (shared.data()) Progress{} : nullptr;
    const pid_t child = progress ? ::fork() : -1;
    if (child < 0) {
        result.ok = false;
        result.failure.reason = "no process for the decoder";
        return result;
    }
    if (child == 0) work(count, step, limits, *progress);

    int status = 0;
    timespec nap{0, 200'000};
    while (true) {
        const pid_t ended = ::waitpid(child, &status, WNOHANG);
        if (ended == child || (ended < 0 && errno != EINTR)) break;
        if (context.cancelled()) {
            ::kill(child, SIGKILL);
            ::waitpid(child, &status, 0);
            result.ok = false;
            result.cancelled = true;
            return result;
        }
        context.report("read", static_cast<double>(progress->done.load(std::memory_order_acquire)) /
                                   static_cast<double>(count));
        ::nanosleep(&nap, nullptr);
        nap.tv_nsec = std::min(nap.tv_nsec * 2, 20'000'000L);
    }
    const std::size_t done = progress->done.load(std::memory_order_acquire);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0 && done == count) return result;
    result.ok = false;
    result.failure = {done, reason_of(status, *progress)};
    return result;
}

SharedBytes::SharedBytes(std::size_t size) : size_(size) {
    void* memory =
        ::mmap(nullptr, size > 0 ? size : 1, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory != MAP_FAILED) data_ = static_cast<std::byte*>(memory);
}
SharedBytes::SharedBytes(SharedBytes&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}
SharedBytes& SharedBytes::operator=(SharedBytes&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
}
SharedBytes::~SharedBytes() {
    if (data_) ::munmap(data_, size_ > 0 ? size_ : 1);
}

}  // namespace anatomesh
