#include "vdblic/io/frame_list.h"

#include "vdblic/core/errors.h"

#include <gtest/gtest.h>

namespace vdblic {
namespace {

using Frames = std::vector<std::int64_t>;

TEST(ParseFrameList, KnowsAllForms)
{
    EXPECT_EQ(parseFrameList("5"), (Frames{5}));
    EXPECT_EQ(parseFrameList("-5"), (Frames{-5}));
    EXPECT_EQ(parseFrameList("1-4"), (Frames{1, 2, 3, 4}));
    EXPECT_EQ(parseFrameList("-2-1"), (Frames{-2, -1, 0, 1}));
    EXPECT_EQ(parseFrameList("-4--2"), (Frames{-4, -3, -2}));
    EXPECT_EQ(parseFrameList("1-10x3"), (Frames{1, 4, 7, 10}));
    EXPECT_EQ(parseFrameList("1-9x3"), (Frames{1, 4, 7}));
    EXPECT_EQ(parseFrameList("7-7x9"), (Frames{7}));
    EXPECT_EQ(parseFrameList("9,1,5-6"), (Frames{1, 5, 6, 9}));
    EXPECT_EQ(parseFrameList("1-3,2-4"), (Frames{1, 2, 3, 4}));
    EXPECT_EQ(parseFrameList(" 1 , 3-4 "), (Frames{1, 3, 4}));
    EXPECT_EQ(parseFrameList("0001-0003"), (Frames{1, 2, 3}));
    EXPECT_EQ(parseFrameList("1-999999").size(), 999999u);
}

TEST(ParseFrameList, RefusesAnythingElse)
{
    for (const char* text : {"",
                             ",",
                             "1,",
                             ",1",
                             "a",
                             "1-",
                             "-",
                             "1-2-3",
                             "1..3",
                             "1:3",
                             "3-1",
                             "1-5x0",
                             "1-5x-1",
                             "1-5x",
                             "5x2",
                             "1.5",
                             "1e3",
                             "nan",
                             "1 2",
                             "+1",
                             "1-1000001",
                             "1-999999,1000001",
                             "99999999999999",
                             "0-9223372036854775807",
                             "-9223372036854775808-9223372036854775807",
                             "18446744073709551616"}) {
        EXPECT_THROW((void)parseFrameList(text), ParameterError) << "'" << text << "'";
    }
}

} // namespace
} // namespace vdblic
