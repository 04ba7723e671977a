#include "vdblic/io/grid_reference.h"

#include "temporary_folder.h"
#include "vdblic/core/errors.h"

#include <gtest/gtest.h>

namespace vdblic {
namespace {

TEST(GridReference, SplitsAtTheLastColon)
{
    const GridReference plain = parseGridReference("a/b.vdb");
    EXPECT_EQ(plain.path, "a/b.vdb");
    EXPECT_EQ(plain.grid, "");
    const GridReference named = parseGridReference("a:b/c.vdb:vel.x");
    EXPECT_EQ(named.path, "a:b/c.vdb");
    EXPECT_EQ(named.grid, "vel.x");
    for (const char* bad : {"", ":", "a.vdb:", ":density"})
        EXPECT_THROW((void)parseGridReference(bad), ParameterError) << bad;
}

TEST(GridReference, AFileOfTheVeryNameIsMeantAsItIs)
{
    const TemporaryFolder folder;
    const std::filesystem::path file = folder.add("10:30");
    EXPECT_EQ(parseGridReference(file.string()).path, file);
    EXPECT_EQ(parseGridReference(file.string()).grid, "");
    EXPECT_EQ(parseGridReference(file.string() + ":v").path, file);
    EXPECT_EQ(parseGridReference(file.string() + ":v").grid, "v");
}

} // namespace
} // namespace vdblic
