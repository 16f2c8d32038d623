#include "anatomesh_io/dicom/sha256.h"

#include <openssl/evp.h>

#include <algorithm>
#include <array>

namespace anatomesh {

namespace {

std::array<unsigned char, 32> digest_of(std::string_view content) {
    std::array<unsigned char, 32> digest{};
    unsigned int length = 0;
    EVP_Digest(content.data(), content.size(), digest.data(), &length, EVP_sha256(), nullptr);
    return digest;
}

}  // namespace

std::string sha256_text(std::string_view content) {
    constexpr char digits[] = "0123456789abcdef";
    std::string text;
    for (const unsigned char byte : digest_of(content)) {
        text += digits[byte >> 4];
        text += digits[byte & 15];
    }
    return text;
}

std::string derived_uid(std::string_view content) {
    auto bytes = digest_of(content);
    bytes[6] = static_cast<unsigned char>((bytes[6] & 0x0F) | 0x80);
    bytes[8] = static_cast<unsigned char>((bytes[8] & 0x3F) | 0x80);
    // Long division of the 128 bits by ten.
    std::string digits;
    for (bool rest = true; rest;) {
        unsigned carry = 0;
        rest = false;
        for (std::size_t i = 0; i < 16; ++i) {
            const unsigned value = carry << 8 | bytes[i];
            bytes[i] = static_cast<unsigned char>(value / 10);
            carry = value % 10;
            rest = rest || bytes[i] != 0;
        }
        digits += static_cast<char>('0' + carry);
    }
    std::reverse(digits.begin(), digits.end());
    return "2.25." + digits;
}

}  // namespace anatomesh
