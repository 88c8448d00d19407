#include "bullet_bodies.h"

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

namespace mass_spring {
namespace {

btVector3 toBullet(const Eigen::Vector3d& v) {
  const Eigen::Matrix<btScalar, 3, 1> cast = v.cast<btScalar>();
  return {cast.x(), cast.y(), cast.z()};
}

/// All springs as links at their lengths of the start, which Bullet takes for their rest lengths.
/// @param stiffness  what m_kLST of a spring's material is to be
template <typename Stiffness>
std::unique_ptr<btSoftBody> makeBody(const RivalScene& scene, btSoftBodyWorldInfo& info,
                                     Stiffness stiffness) {
  const Model& model = scene.model;
  btAlignedObjectArray<btVector3> positions;
  btAlignedObjectArray<btScalar> masses;
  for (std::uint32_t i = 0; i < model.particleCount(); ++i) {
    positions.push_back(toBullet(model.start.positions.col(i)));
    // Of no mass: fixed.
    masses.push_back(scene.pinned[i] ? 0 : static_cast<btScalar>(model.masses[i]));
  }
  auto body = std::make_unique<btSoftBody>(&info, positions.size(), &positions[0], &masses[0]);
  std::vector<std::pair<double, btSoftBody::Material*>> materials;
  for (const Spring& spring : model.springs) {
    const double wanted = stiffness(spring);
    btSoftBody::Material* material = nullptr;
    for (const auto& known : materials) {
      if (known.first == wanted) material = known.second;
    }
    if (material == nullptr) {
      material = body->appendMaterial();
      material->m_kLST = static_cast<btScalar>(wanted);
      materials.emplace_back(wanted, material);
    }
    body->appendLink(static_cast<int>(spring.i), static_cast<int>(spring.j), material);
  }
  body->m_cfg.collisions = 0;
  body->setActivationState(DISABLE_DEACTIVATION);
  return body;
}

Vectors positionsOf(const btSoftBody& body) {
  Vectors positions(3, body.m_nodes.size());
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    const btVector3& x = body.m_nodes[i].m_x;
    positions.col(i) << x.x(), x.y(), x.z();
  }
  return positions;
}

/// btDeformableMassSpringForce knows one stiffness and one for bending; this takes each link's from
/// its material, and is else the same, operation by operation.
class LinkForce : public btDeformableMassSpringForce {
 public:
  explicit LinkForce(btScalar damping) : btDeformableMassSpringForce(1, damping, true) {}

  void addScaledElasticForce(btScalar scale, TVStack& force) override {
    for (int b = 0; b < m_softBodies.size(); ++b) {
      const btSoftBody& body = *m_softBodies[b];
      for (int k = 0; k < body.m_links.size(); ++k) {
        const btSoftBody::Link& link = body.m_links[k];
        const btVector3 d = link.m_n[1]->m_q - link.m_n[0]->m_q;
        const btScalar length = d.length();
        if (!(length > SIMD_EPSILON)) continue;
        const btVector3 pull = d * (scale * link.m_material->m_kLST * (1 - link.m_rl / length));
        force[link.m_n[0]->index] += pull;
        force[link.m_n[1]->index] -= pull;
      }
    }
  }

  void addScaledElasticForceDifferential(btScalar scale, const TVStack& dx,
                                         TVStack& change) override {
    for (int b = 0; b < m_softBodies.size(); ++b) {
      const btSoftBody& body = *m_softBodies[b];
      for (int k = 0; k < body.m_links.size(); ++k) {
        const btSoftBody::Link& link = body.m_links[k];
        const btVector3 d = link.m_n[1]->m_q - link.m_n[0]->m_q;
        const btScalar length = d.length();
        if (!(length > SIMD_EPSILON)) continue;
        const btVector3 n = d / length;
        const btScalar stiffness = scale * link.m_material->m_kLST;
        const btScalar across = 1 - link.m_rl / length;
        const btVector3 by = dx[link.m_n[0]->index] - dx[link.m_n[1]->index];
        const btVector3 pull =
            (stiffness * (across - 1) * n.dot(by)) * n - (stiffness * across) * by;
        change[link.m_n[0]->index] += pull;
        change[link.m_n[1]->index] -= pull;
      }
    }
  }

  double totalElasticEnergy(btScalar) override {
    double energy = 0.0;
    for (int b = 0; b < m_softBodies.size(); ++b) {
      const btSoftBody& body = *m_softBodies[b];
      for (int k = 0; k < body.m_links.size(); ++k) {
        const btSoftBody::Link& link = body.m_links[k];
        const btScalar stretch = (link.m_n[1]->m_q - link.m_n[0]->m_q).length() - link.m_rl;
        energy += 0.5 * link.m_material->m_kLST * stretch * stretch;
      }
    }
    return energy;
  }
};

/// What every world of Bullet's is made of.
struct Parts {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
};

enum class Integration { kExplicit, kOneNewton, kLineSearch };

class DeformableSolver : public btDeformableBodySolver {
 public:
  explicit DeformableSolver(Integration integration) {
    m_maxNewtonIterations = integration == Integration::kLineSearch ? 5 : 1;
    setImplicit(integration != Integration::kExplicit);
    setLineSearch(integration == Integration::kLineSearch);
  }
};

class BulletDeformable : public Rival {
 public:
  BulletDeformable(const RivalScene& scene, int substeps, Integration integration)
      : step_(scene.step),
        substeps_(substeps),
        solver_(integration),
        world_(&parts_.dispatcher, &parts_.broadphase, &constraints_, &parts_.configuration,
               &solver_),
        gravity_(toBullet(scene.gravity)),
        springs_(static_cast<btScalar>(scene.model.springs.front().damping)) {
    constraints_.setDeformableSolver(&solver_);
    world_.setImplicit(integration != Integration::kExplicit);
    world_.setLineSearch(integration == Integration::kLineSearch);
    // Else fixed nodes are Lagrange multipliers, and with them nothing moves in the implicit mode.
    world_.setUseProjection(true);
    world_.setGravity(toBullet(scene.gravity));
    body_ = makeBody(scene, world_.getWorldInfo(),
                     [](const Spring& spring) { return spring.stiffness; });
    world_.addSoftBody(body_.get());
    world_.addForce(body_.get(), &springs_);
    world_.addForce(body_.get(), &gravity_);
  }
  ~BulletDeformable() override { world_.removeSoftBody(body_.get()); }

  void step() override {
    const auto h = static_cast<btScalar>(step_ / substeps_);
    for (int substep = 0; substep < substeps_; ++substep) world_.stepSimulation(h, 0);
  }
  Vectors positions() const override { return positionsOf(*body_); }

 private:
  double step_;
  int substeps_;
  Parts parts_;
  DeformableSolver solver_;
  btDeformableMultiBodyConstraintSolver constraints_;
  btDeformableMultiBodyDynamicsWorld world_;
  btDeformableGravityForce gravity_;
  LinkForce springs_;
  std::unique_ptr<btSoftBody> body_;
};

class BulletPositionBased : public Rival {
 public:
  BulletPositionBased(const RivalScene& scene, int substeps, int iterations)
      : step_(scene.step),
        substeps_(substeps),
        world_(&parts_.dispatcher, &parts_.broadphase, &constraints_, &parts_.configuration) {
    world_.getWorldInfo().m_gravity = toBullet(scene.gravity);
    world_.getWorldInfo().m_sparsesdf.Initialize();
    body_ = makeBody(scene, world_.getWorldInfo(), [](const Spring&) { return 1.0; });
    body_->m_cfg.piterations = iterations;
    world_.addSoftBody(body_.get());
  }
  ~BulletPositionBased() override { world_.removeSoftBody(body_.get()); }

  void step() override {
    const auto h = static_cast<btScalar>(step_ / substeps_);
    for (int substep = 0; substep < substeps_; ++substep) world_.stepSimulation(h, 0);
  }
  Vectors positions() const override { return positionsOf(*body_); }

 private:
  double step_;
  int substeps_;
  Parts parts_;
  btSequentialImpulseConstraintSolver constraints_;
  btSoftRigidDynamicsWorld world_;
  std::unique_ptr<btSoftBody> body_;
};

}  // namespace

std::vector<RivalSeries> bulletSeries() {
  const auto deformable = [](const char* name, Integration integration) {
    RivalSeries series{name, {}};
    for (const int n : {1, 2, 5, 10, 20, 30, 40, 50, 100, 200, 500, 1000, 2000, 5000, 10000}) {
      series.settings.push_back({std::to_string(n) + " sub-steps",
                                 [=](const RivalScene& scene) -> std::unique_ptr<Rival> {
                                   return std::make_unique<BulletDeformable>(scene, n, integration);
                                 }});
    }
    return series;
  };
  std::vector<RivalSeries> all = {
      deformable("Bullet deformable explicit", Integration::kExplicit),
      deformable("Bullet deformable implicit", Integration::kOneNewton),
      deformable("Bullet deformable line search", Integration::kLineSearch)};
  RivalSeries position_based{"Bullet position based", {}};
  for (const auto& [substeps, iterations] : std::vector<std::pair<int, int>>{
           {1, 1}, {1, 5}, {1, 10}, {1, 50}, {5, 10}, {20, 10}, {100, 10}}) {
    position_based.settings.push_back(
        {std::to_string(substeps) + " x " + std::to_string(iterations),
         [substeps = substeps,
          iterations = iterations](const RivalScene& scene) -> std::unique_ptr<Rival> {
           return std::make_unique<BulletPositionBased>(scene, substeps, iterations);
         }});
  }
  all.push_back(position_based);
  return all;
}

}  // namespace mass_spring
