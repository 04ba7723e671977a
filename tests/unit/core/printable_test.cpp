#include "vdblic/core/printable.h"

#include <gtest/gtest.h>

#include <string>

namespace vdblic {
namespace {

TEST(Printable, KeepsWords)
{
    for (const std::string text : {"", "wind", "a 'b' \"c\" \\n <d> & `e`", "Größe ±1 → ∞ 速度 \xf0\x9f\x8c\x80"})
        EXPECT_EQ(printable(text), text);
}

TEST(Printable, EscapesWhatControlsATerminal)
{
    EXPECT_EQ(printable("a\x1b]0;title\x07"), "a\\x1b]0;title\\x07");
    EXPECT_EQ(printable("a\nvdblic: error: b\r\t\x7f"), "a\\nvdblic: error: b\\r\\t\\x7f");
    EXPECT_EQ(printable(std::string("a\0b", 3)), "a\\x00b");
    EXPECT_EQ(printable("\xc2\x9b[2J \xe2\x80\xae \xe2\x80\xa8 \xe2\x81\xa6"), "\\u009b[2J \\u202e \\u2028 \\u2066");
}

TEST(Printable, EscapesWhatIsNoUtf8)
{
    EXPECT_EQ(printable("a\xff\x9b[2J"), "a\\xff\\x9b[2J");
    EXPECT_EQ(printable("\xc3"), "\\xc3");                            // cut off
    EXPECT_EQ(printable("\xc0\xaf"), "\\xc0\\xaf");                   // a longer form than needed
    EXPECT_EQ(printable("\xed\xa0\x80"), "\\xed\\xa0\\x80");          // half of a pair of UTF-16
    EXPECT_EQ(printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80"); // beyond the last character
    EXPECT_EQ(printable("\xe2\x82z"), "\\xe2\\x82z");
}

TEST(Printable, IsTheSameTwice)
{
    std::string all;
    for (int byte = 0; byte < 256; ++byte)
        all += char(byte);
    EXPECT_EQ(printable(printable(all)), printable(all));
    EXPECT_EQ(printable(all).find_first_of("\n\x1b\x7f"), std::string::npos);
}

} // namespace
} // namespace vdblic
