// The end of a process that has no memory left, not even for the message: exit code 5, wherever it strikes.
#include <cxxabi.h>
#include <unistd.h>

#include <cstdlib>
#include <exception>
#include <new>
#include <string_view>
#include <typeinfo>

namespace anatomesh {

namespace {

// As exit_code() of ErrorKind::limit. [exit code; 0 to 255; D]
constexpr int exit_code_of_limits = 5;
constexpr std::string_view message =
    "anatomesh: E-CMD-010: the memory does not suffice (next: a larger --size or --every needs less "
    "memory)\n";

bool is_end_of_memory(const std::type_info* thrown) {
    return thrown && (*thrown == typeid(std::bad_alloc) || *thrown == typeid(std::bad_array_new_length));
}

// Allocates nothing. No destructor runs after it: temporary files are removed by the next run, as after a kill.
[[noreturn]] void on_terminate() {
    if (is_end_of_memory(abi::__cxa_current_exception_type())) {
        const ssize_t ignored = ::write(STDERR_FILENO, message.data(), message.size());
        static_cast<void>(ignored);
        ::_exit(exit_code_of_limits);
    }
    std::abort();
}

// Before the constructors of shared libraries, which allocate as well.
void take_over(int, char**, char**) {
    std::set_terminate(on_terminate);
}

}  // namespace

__attribute__((section(".preinit_array"), used)) void (*const before_all_constructors)(int, char**,
                                                                                       char**) = take_over;

}  // namespace anatomesh
