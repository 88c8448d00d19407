#pragma once

#include "rival.h"

namespace mass_spring {

/// Bullet's soft bodies in single precision, as Debian's packages link it by default. In double
/// precision its conjugate gradients go on to 2e-16 (their tolerance is SIMD_EPSILON).
///
/// Deformable: btDeformableMultiBodyDynamicsWorld, springs explicit with damping implicit, or all
/// implicit with one Newton iteration and with up to five and a line search. Position based:
/// btSoftBody in btSoftRigidDynamicsWorld, whose stiffness is a share in [0, 1] and is left at 1.
/// Fixed nodes by projection. No collisions, no faces, no deactivation.
std::vector<RivalSeries> bulletSeries();

}  // namespace mass_spring
