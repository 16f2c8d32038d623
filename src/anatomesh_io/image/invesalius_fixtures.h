// InVesalius projects written for tests, good and bad.
#pragma once

#include <cstdint>
#include <string>

namespace anatomesh::fixtures {

inline std::string octal(std::uint64_t value, int digits) {
    std::string text(static_cast<std::size_t>(digits), '0');
    for (int i = digits - 1; i >= 0; --i, value /= 8)
        text[static_cast<std::size_t>(i)] = static_cast<char>('0' + value % 8);
    return text;
}

inline std::string tar_entry(const std::string& name, const std::string& content, std::uint64_t claimed) {
    std::string header(512, '\0');
    header.replace(0, name.size(), name);
    header.replace(100, 7, "0000644");
    header.replace(124, 11, octal(claimed, 11));
    header[156] = '0';
    header.replace(257, 7, "ustar  ");
    header.replace(148, 8, "        ");
    unsigned sum = 0;
    for (const char c : header) sum += static_cast<unsigned char>(c);
    header.replace(148, 7, octal(sum, 6) + '\0');
    std::string padded = content;
    padded.resize((content.size() + 511) / 512 * 512);
    return header + padded;
}

inline std::string tar_entry(const std::string& name, const std::string& content) {
    return tar_entry(name, content, content.size());
}

inline std::string plist(const std::string& type = "int16", const std::string& shape = "5 4 3",
                         const std::string& spacing = "0.75 0.5 2") {
    const auto array = [](const std::string& words, const std::string& tag) {
        std::string text = "<array>";
        std::size_t begin = 0;
        while (begin < words.size()) {
            const std::size_t end = std::min(words.find(' ', begin), words.size());
            text += "<" + tag + ">" + words.substr(begin, end - begin) + "</" + tag + ">\n";
            begin = end + 1;
        }
        return text + "</array>";
    };
    return "<?xml version=\"1.0\"?>\n<!DOCTYPE plist PUBLIC \"-//Apple Computer//DTD PLIST 1.0//EN\" \"x\">\n"
           "<plist version=\"1.0\">\n<dict>\n<key>annotations</key><dict></dict><key>matrix</key>\n<dict>"
           "<key>dtype</key><string>" +
           type +
           "</string><key>filename</key><string>matrix.dat</string>"
           "<key>shape</key>" +
           array(shape, "integer") +
           "</dict><key>name</key><string>a &lt; b</string>"
           "<key>spacing</key>" +
           array(spacing, "real") + "</dict></plist>";
}

inline std::string project(const std::string& list, const std::string& matrix) {
    return tar_entry("tmp/main.plist", list) + tar_entry("tmp/mask_0.dat", std::string(700, 'm')) +
           tar_entry("tmp/matrix.dat", matrix) + std::string(1024, '\0');
}

}  // namespace anatomesh::fixtures
