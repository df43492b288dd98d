// One decimal number in text, to the last bit.
#pragma once

#include <bit>
#include <cfloat>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <string>
#include <system_error>
#include <version>

#include "simd.hpp"

namespace retime {

inline bool is_digit(char c) { return static_cast<unsigned char>(c - '0') < 10; }

// Powers of ten that a double holds exactly.
constexpr double kPowers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                              1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
constexpr int64_t kMostPower = 22;
constexpr uint64_t kWholePowers[] = {1, 10, 100, 1000, 10000, 100000, 1000000, 10000000, 100000000};
// Digits that always fit into 64 bits.
constexpr int64_t kMostDigits = 19;

// The nearest double, by the standard library; false where it has none to give: no such function, or a number beyond
// the range of doubles (one that rounds to 0 too).
inline bool nearest_double(const char* text, const char* end, bool has_comma, double& value) {
#if defined(__cpp_lib_to_chars)
    std::string plain;
    if (has_comma) {
        plain.assign(text, end);
        plain[plain.find(',')] = '.';
        text = plain.data();
        end = text + plain.size();
    }
    const auto [stop, error] = std::from_chars(text, end, value);
    return error == std::errc() && stop == end;
#else
    return false;
#endif
}

// Reads the number that begins at `at`: true, and `at` behind it. False where none does, where it is larger than
// `largest`, or where only another reader knows its nearest double. What follows it is the caller's to judge.
inline bool read_number(const char*& at, const char* end, bool decimal_comma, double largest, double& value) {
    const char* p = at;
    const bool negative = p < end && *p == '-';
    if (p < end && (*p == '-' || *p == '+')) ++p;
    const char* const digits = p;
    // The digits as a whole number; it wraps around where there are too many, and is not used then.
    uint64_t whole = 0;
    for (; p < end && is_digit(*p); ++p) whole = 10 * whole + static_cast<uint64_t>(*p - '0');
    int64_t n_digits = p - digits;
    int64_t power = 0;
    bool has_comma = false;
    if (p < end && (*p == '.' || (decimal_comma && *p == ','))) {
        has_comma = *p == ',';
        const char* const decimals = ++p;
        for (; p < end && is_digit(*p); ++p) whole = 10 * whole + static_cast<uint64_t>(*p - '0');
        power = decimals - p;
        n_digits -= power;
    }
    if (n_digits == 0) return false;
    if (p < end && (*p == 'e' || *p == 'E')) {
        ++p;
        const bool small = p < end && *p == '-';
        if (p < end && (*p == '-' || *p == '+')) ++p;
        if (p == end || !is_digit(*p)) return false;
        int64_t exponent = 0;
        for (; p < end && is_digit(*p); ++p)
            if (exponent < 1'000'000) exponent = 10 * exponent + (*p - '0');
        power += small ? -exponent : exponent;
    }
    // Zeros in front are no digits that count, nor is the point among them.
    if (n_digits > kMostDigits)
        for (const char* zero = digits; zero < p && (*zero == '0' || *zero == '.' || *zero == ','); ++zero)
            n_digits -= *zero == '0';
    // Both are exact as doubles then, and IEEE arithmetic rounds their quotient or product once: correctly. (Where
    // expressions are evaluated in a wider type it would round twice.)
    constexpr bool rounds_once = FLT_EVAL_METHOD == 0;
    if (rounds_once && n_digits <= kMostDigits && whole <= (uint64_t{1} << 53) && -power <= kMostPower &&
        power <= kMostPower) {
        const double exact = static_cast<double>(whole);
        value = power < 0 ? exact / kPowers[-power] : exact * kPowers[power];
    } else if (!nearest_double(digits, p, has_comma, value)) {
        return false;
    }
    if (!(value <= largest)) return false;
    if (negative) value = -value;
    at = p;
    return true;
}

#if RETIME_X86

// The whole number of the first n of eight digits, 1 to 8 of them.
inline uint64_t digits_at(const char* at, size_t n) {
    uint64_t bytes;
    std::memcpy(&bytes, at, 8);
    // Zeros in front of fewer digits; then pairs, fours and all eight are joined.
    bytes = (bytes ^ 0x3030303030303030u) << 8 * (8 - n);
    bytes = bytes * 10 + (bytes >> 8);
    constexpr uint64_t pairs = 0x000000ff000000ffu;
    return ((bytes & pairs) * 0x000f424000000064u + (bytes >> 16 & pairs) * 0x0000271000000001u) >> 32;
}

// The same as read_number for what most files hold: up to eight digits, and up to eight decimals. False for all else,
// which may be a number nevertheless. Where the number ends is known from one comparison of all its bytes, so that the
// processor can go on to the next one while it works this one out.
inline bool read_short_number(const char*& at, const char* end, char delimiter, double largest, double& value) {
    // What is looked at: a sign, eight digits, a point, eight digits; and whole words of each.
    if (end - at < 32) return false;
    const __m128i bytes = _mm_loadu_si128(reinterpret_cast<const __m128i*>(at));
    const auto bits = [](__m128i which) { return static_cast<uint32_t>(_mm_movemask_epi8(which)); };
    // Bytes up to ' ' end a number, and so does the delimiter (or, where there is none, the byte 0).
    const __m128i blank = _mm_cmpeq_epi8(_mm_min_epu8(bytes, _mm_set1_epi8(' ')), bytes);
    const uint32_t ends = bits(_mm_or_si128(blank, _mm_cmpeq_epi8(bytes, _mm_set1_epi8(delimiter))));
    if (ends == 0) return false;
    const uint32_t before_end = (ends & -ends) - 1;
    const size_t length = next_bit(ends);
    const __m128i from_zero = _mm_sub_epi8(bytes, _mm_set1_epi8('0'));
    const uint32_t digits = bits(_mm_cmpeq_epi8(_mm_min_epu8(from_zero, _mm_set1_epi8(9)), from_zero));
    const uint32_t points = bits(_mm_cmpeq_epi8(bytes, _mm_set1_epi8('.'))) & before_end, point = points & -points;
    const bool negative = *at == '-';
    const size_t sign = negative || *at == '+';
    if ((before_end & ~(digits | point)) != sign) return false;
    const size_t whole_end = point ? next_bit(point) : length, n_whole = whole_end - sign;
    const size_t n_decimals = point ? length - whole_end - 1 : 0;
    if (n_whole - 1 > 7 || n_decimals > 8 || (point && n_decimals == 0)) return false;
    uint64_t whole = digits_at(at + sign, n_whole);
    if (point) whole = whole * kWholePowers[n_decimals] + digits_at(at + whole_end + 1, n_decimals);
    if (whole > uint64_t{1} << 53) return false;
    // Both are exact: one rounding, as below.
    const double number = static_cast<double>(whole) / kPowers[n_decimals];
    if (!(number <= largest)) return false;
    value = negative ? -number : number;
    at += length;
    return true;
}

#else

inline bool read_short_number(const char*&, const char*, char, double, double&) { return false; }

#endif

}  // namespace retime
