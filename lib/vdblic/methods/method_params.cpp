#include "vdblic/methods/method_params.h"

namespace vdblic {

int lifeSpanOf(const MethodParams& params)
{
    return params.texture.lifeSpan;
}

int twoLifeSpansOf(const MethodParams& params)
{
    return 2 * params.texture.lifeSpan; // longer ones bring a part no closer to the whole run
}

void describeLifeSpan(const MethodParams& params, openvdb::MetaMap& metadata)
{
    metadata.insertMeta("life_span", openvdb::Int32Metadata(params.texture.lifeSpan));
}

} // namespace vdblic
