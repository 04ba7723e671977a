#include "vdblic/run/run_outputs.h"

#include "temporary_folder.h"
#include "vdblic/core/errors.h"
#include "vdblic/run/advect_plan.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <limits>

#include <string>

namespace vdblic {
namespace {

TEST(RunOutputs, NamesTheCheckpointBesideTheTextures)
{
    AdvectParams params;
    params.output = "folder/lic.%04d.vdb";
    const AdvectPlan plan = resolve(params);
    const RunOutputs outputs(plan);
    EXPECT_EQ(outputs.texture(7, 0), "folder/lic.0007.vdb");
    EXPECT_EQ(outputs.checkpoint(), "folder/checkpoint.lic.vdb");
}

TEST(RunOutputs, CountSubstepsFromTheFirstFrame)
{
    AdvectParams params;
    params.output = "lic.%04d.vdb";
    params.texture.substeps = 12;
    const AdvectPlan plan = resolve(params);
    RunOutputs outputs(plan);
    outputs.startAt(-3);
    outputs.startAt(5); // has no effect
    EXPECT_EQ(outputs.number(-3, 0), -3);
    EXPECT_EQ(outputs.number(-3, 11), 8);
    EXPECT_EQ(outputs.number(-2, 0), 9);
    EXPECT_EQ(outputs.number(7, 5), 122);
    EXPECT_THROW((void)outputs.number(std::numeric_limits<std::int64_t>::max() / 6, 0), ParameterError);
}

TEST(RunOutputs, MustDiffer)
{
    const TemporaryFolder folder;
    for (const char* name : {"v.0001.vdb", "v.0002.vdb"})
        folder.add(name);
    AdvectParams params;
    params.flow.input.pattern = (folder / "v.%04d.vdb").string();
    params.output = (folder / "lic.%04d.vdb").string();
    const auto check = [&](const std::string& report) {
        params.json = report.empty() ? "" : (folder / report).string();
        RunOutputs(resolve(params)).check(2);
    };
    EXPECT_NO_THROW(check(""));
    EXPECT_NO_THROW(check("report.json"));
    EXPECT_THROW(check("lic.0009.vdb"), ParameterError);
    EXPECT_THROW(check("checkpoint.lic.vdb"), ParameterError);
    EXPECT_THROW(check("none/report.json"), OutputError);
    std::filesystem::create_directory(folder / "lic.0002.vdb");
    EXPECT_THROW(check(""), ParameterError);
    params = {};
    params.flow.input.pattern = (folder / "v.0001.vdb").string();
    params.output = (folder / "lic.vdb").string();
    EXPECT_NO_THROW(RunOutputs(resolve(params)).check(1));
    EXPECT_THROW(RunOutputs(resolve(params)).check(2), ParameterError);
}

TEST(RunOutputs, OfSubstepsReplaceNoLaterInput)
{
    const TemporaryFolder folder;
    for (const char* name : {"v.0001.vdb", "v.0003.vdb"})
        folder.add(name, "content");
    AdvectParams params;
    params.flow.input.pattern = params.output = (folder / "v.%04d.vdb").string();
    EXPECT_THROW(RunOutputs(resolve(params)).checkInputs({1, folder / "v.0001.vdb"}), ParameterError);
    params.output = (folder / "v.%03d.vdb").string();
    params.texture.substeps = 2;
    EXPECT_NO_THROW(RunOutputs(resolve(params)).checkInputs({1, folder / "v.0001.vdb"}));
    params.output = (folder / "v.0%03d.vdb").string();
    EXPECT_NO_THROW(RunOutputs(resolve(params)).checkInputs({5, folder / "elsewhere.vdb"}));
    EXPECT_THROW(RunOutputs(resolve(params)).checkInputs({2, folder / "elsewhere.vdb"}), ParameterError);
}

TEST(RunOutputs, ReplaceNoInput)
{
    const TemporaryFolder folder;
    for (const char* name : {"v.0003.vdb", "a.0003.vdb", "checkpoint.a.vdb", "report.json"})
        folder.add(name, "content");
    const auto check = [&](const std::string& velocity, AdvectParams params) {
        params.output = (folder / "a.%04d.vdb").string();
        params.json = (folder / "report.json").string();
        RunOutputs(resolve(params)).checkInputs({3, folder / velocity});
    };
    EXPECT_NO_THROW(check("v.0003.vdb", {}));
    for (const char* output : {"a.0003.vdb", "checkpoint.a.vdb", "report.json"}) {
        EXPECT_THROW(check(output, {}), ParameterError) << output;
        AdvectParams masked, noisy;
        masked.flow.domain.mask = (folder / output).string();
        EXPECT_THROW(check("v.0003.vdb", masked), ParameterError) << output;
        noisy.noise = (folder / output).string();
        EXPECT_THROW(check("v.0003.vdb", noisy), ParameterError) << output;
    }
    AdvectParams sequence; // of masks, one of which is the output
    sequence.flow.domain.mask = (folder / "a.%04d.vdb").string();
    EXPECT_THROW(check("v.0003.vdb", sequence), ParameterError);
}

} // namespace
} // namespace vdblic
