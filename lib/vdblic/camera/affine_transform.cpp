#include "vdblic/camera/affine_transform.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/affine_rows.h"

#include <fmt/format.h>
#include <glm/matrix.hpp>
#include <openvdb/openvdb.h>

#include <cmath>

namespace vdblic {

glm::dmat4 affineMatrix(const openvdb::math::Transform& transform, const std::string& grid)
{
    if (!transform.isLinear()) {
        throw InputError(fmt::format("{} has a {} transform; only affine ones can be rendered: resample it first", grid,
                                     transform.mapType()));
    }
    const openvdb::Mat4d matrix = affineRows(transform);
    glm::dmat4 result;
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j)
            result[i][j] = matrix[i][j]; // OpenVDB's rows are GLM's columns
    }
    if (!(std::abs(glm::determinant(glm::dmat3(result))) > 0) || !std::isfinite(glm::determinant(result)))
        throw InputError(fmt::format("{} has a transform that flattens space; give its voxels a size", grid));
    return result;
}

} // namespace vdblic
