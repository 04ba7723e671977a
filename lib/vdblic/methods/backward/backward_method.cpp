#include "vdblic/methods/backward/backward_method.h"

#include "vdblic/methods/memory_estimate.h"

namespace vdblic {

int settlingFrames(const MethodParams& params)
{
    return params.backward.settlingFrames(params.texture.lifeSpan);
}

void describeBlended(const MethodParams& params, openvdb::MetaMap& metadata)
{
    describeLifeSpan(params, metadata);
    metadata.insertMeta("alpha", openvdb::FloatMetadata(float(params.backward.shareFor(params.texture.lifeSpan))));
}

double backwardBytes(double carried, double brick, double velocity, double texture)
{
    const double leaves = texture / Domain::kLeafVoxels;
    return kProcessBytes + kVelocityBytes * velocity + sizeof(float) * (1 + 2 * carried) * texture +
           partInBricks(leaves) * (velocity / Domain::kLeafVoxels * kVelocityBrickBytes + leaves * brick);
}

} // namespace vdblic
