// One decimal number in text, to the last bit.
#pragma once

#include <cfloat>
#include <charconv>
#include <cstdint>
#include <string>
#include <system_error>
#include <version>

namespace retime {

inline bool is_digit(char c) { return static_cast<unsigned char>(c - '0') < 10; }

// Powers of ten that a double holds exactly.
constexpr double kPowers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                              1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
constexpr int64_t kMostPower = 22;
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

}  // namespace retime
