// CommaLocale: the process in a locale that writes a half as "0,5", for tests that numbers do not depend on
// it.
#pragma once

#include <stdlib.h>
#include <unistd.h>

#include <clocale>
#include <cstdlib>
#include <filesystem>
#include <string>

namespace anatomesh::fixtures {

// Takes the system's German locale, or has localedef make one in a temporary folder; the C locale returns at
// the end. Not for several threads at once.
class CommaLocale {
  public:
    CommaLocale() {
        if (std::setlocale(LC_ALL, "de_DE.UTF-8")) return;
        std::string pattern = (std::filesystem::temp_directory_path() / "anatomesh-locale-XXXXXX").string();
        if (!::mkdtemp(pattern.data())) return;
        folder_ = pattern;
        const std::string command =
            "localedef -i de_DE -f UTF-8 '" + (folder_ / "de_DE.UTF-8").string() + "' 2>/dev/null";
        std::system(command.c_str());  // warnings make its status other than 0: what counts is the locale
        ::setenv("LOCPATH", folder_.c_str(), 1);
        std::setlocale(LC_ALL, "de_DE.UTF-8");
    }
    ~CommaLocale() {
        std::setlocale(LC_ALL, "C");
        if (folder_.empty()) return;
        ::unsetenv("LOCPATH");
        std::error_code ignored;
        std::filesystem::remove_all(folder_, ignored);
    }
    CommaLocale(const CommaLocale&) = delete;
    CommaLocale& operator=(const CommaLocale&) = delete;

    // False where there is no such locale and none could be made (package locales).
    bool is_there() const { return std::string(std::localeconv()->decimal_point) == ","; }

  private:
    std::filesystem::path folder_;
};

}  // namespace anatomesh::fixtures
