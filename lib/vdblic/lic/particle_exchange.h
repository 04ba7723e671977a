#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/distributed/partition.h"
#include "vdblic/field/domain.h"
#include "vdblic/lic/particle_bins.h"

#include <vector>

namespace vdblic {

/// Hand the particles that left a rank's own leaves on to the ranks that own the leaves they are in. Collective.
/// @param domain of the step to come, with this rank's own leaves; its local ones are all that a particle can have
///               reached
/// @param bins   by the leaves of the domain
void handOn(Exchange& exchange, const Partition& partition, const Domain& domain, std::vector<ParticleBins>& bins);

} // namespace vdblic
