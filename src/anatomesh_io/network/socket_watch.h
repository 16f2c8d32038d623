// SocketWatch: watches a socket that a library waits at, and shuts it down as soon as a judge says so. The
// library then fails as if the peer had closed. It needs no word from the library: it reads from the system how
// much has come.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "anatomesh/base/result.h"

namespace anatomesh {

class SocketWatch {
  public:
    // The error to end the socket with; nothing: it may go on. `taken`: bytes since begin() that the library
    // has taken from the system, with all framing. Called from a thread of the watch's own, 20 times a second.
    using Judge = std::function<std::optional<Error>(std::uint64_t taken)>;

    SocketWatch();
    SocketWatch(const SocketWatch&) = delete;
    SocketWatch& operator=(const SocketWatch&) = delete;
    ~SocketWatch();

    // From now on this socket is the one, whichever was before. Thread-safe. The caller may close it at any time.
    void follow(int descriptor);
    // Error (file): E-NET-016 the system gives no descriptor or no thread.
    Status begin(Judge judge);
    // The first error of the judge, if there was one.
    std::optional<Error> end();

  private:
    void run();

    std::mutex mutex_;
    std::condition_variable wake_;
    std::thread thread_;
    Judge judge_;
    std::optional<Error> verdict_;
    bool is_ending_ = false, is_connected_ = false;
    int descriptor_ = -1;       // a copy, so that no other file takes its number
    std::uint64_t before_ = 0;  // bytes of the socket when begin() was called
};

}  // namespace anatomesh
