#include "anatomesh_io/network/socket_watch.h"

#include <fcntl.h>
#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <system_error>
#include <utility>

namespace anatomesh {

namespace {

// A wish to stop is heeded, and memory is looked at, as often as this. [ms; > 0; B]
constexpr std::chrono::milliseconds watch_interval{50};

// Bytes that have come over a connection and were read from it.
std::uint64_t bytes_taken_from(int descriptor) {
    tcp_info info{};
    socklen_t size = sizeof info;
    int waiting = 0;
    if (::ioctl(descriptor, FIONREAD, &waiting) != 0) return 0;
    if (::getsockopt(descriptor, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return 0;
    constexpr std::size_t needed = offsetof(tcp_info, tcpi_bytes_received) + sizeof info.tcpi_bytes_received;
    const std::uint64_t received = size >= needed ? info.tcpi_bytes_received : 0;
    return received - std::min<std::uint64_t>(received, static_cast<std::uint64_t>(waiting));
}

}  // namespace

// The number is taken at once: what is to end a socket must not fail when descriptors run out.
SocketWatch::SocketWatch() : descriptor_(::open("/dev/null", O_RDONLY | O_CLOEXEC)) {}

SocketWatch::~SocketWatch() {
    end();
    if (descriptor_ >= 0) ::close(descriptor_);
}

void SocketWatch::follow(int descriptor) {
    const std::lock_guard lock(mutex_);
    if (descriptor_ < 0) return;
    is_connected_ = ::dup3(descriptor, descriptor_, O_CLOEXEC) >= 0;
    before_ = 0;
}

Status SocketWatch::begin(Judge judge) {
    assert(!thread_.joinable());
    judge_ = std::move(judge);
    verdict_.reset();
    is_ending_ = false;
    before_ = is_connected_ ? bytes_taken_from(descriptor_) : 0;
    const char* missing = descriptor_ < 0 ? "descriptor" : nullptr;
    try {
        if (!missing) thread_ = std::thread([this] { run(); });
    } catch (const std::system_error&) {
        missing = "thread";
    }
    if (!missing) return Nothing{};
    return Error{ErrorKind::file,
                 "E-NET-016",
                 std::string("the system gives no ") + missing + " to watch over the request with",
                 {},
                 "end other programs, or raise the limits of the system (ulimit)"};
}

std::optional<Error> SocketWatch::end() {
    {
        const std::lock_guard lock(mutex_);
        is_ending_ = true;
    }
    wake_.notify_one();
    if (thread_.joinable()) thread_.join();
    return std::exchange(verdict_, std::nullopt);
}

void SocketWatch::run() {
    std::unique_lock lock(mutex_);
    while (!is_ending_) {
        const std::uint64_t taken = is_connected_ ? bytes_taken_from(descriptor_) : 0;
        if (!verdict_) verdict_ = judge_(taken - std::min(taken, before_));
        // Again and again: the library may try another address with another socket.
        if (verdict_ && is_connected_) ::shutdown(descriptor_, SHUT_RDWR);
        wake_.wait_for(lock, watch_interval);
    }
}

}  // namespace anatomesh
