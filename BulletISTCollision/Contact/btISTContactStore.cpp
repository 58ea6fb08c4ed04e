// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Contact/btISTContactStore.h"

#include "BulletISTCollision/Core/Faces/ContactFaces.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Tuning/StableTimeStep.h"

#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "BulletDynamics/Featherstone/btMultiBody.h"
#include "BulletDynamics/Featherstone/btMultiBodyLinkCollider.h"

#include <algorithm>
#include <cmath>

namespace
{
// Mean depth at which bodies rest, as a share of their size. The deepest point of a ball is twice as deep, that of a cone three times.
constexpr double kDepthPerSize = 3e-4;
constexpr double kSizePerThickness = 3;  // of a cube
// Contact that is shallower than the errors of the surfaces feels them as bumps. It is deeper for them, but no deeper than the larger of
// these.
constexpr double kDepthPerError = 2, kDepthOnBumpsPerSize = 2e-3, kDepthOnBumpsPerThickness = 5e-3;
// Largest mean depth that a weight may reach.
constexpr double kMostDepthPerSize = 5e-3, kMostDepthPerThickness = 0.05;
// Depth to which the weight alone presses a pair before it is known what else presses, and where. In a tight fit nothing presses, and a
// stiff one would jam.
constexpr double kFirstDepthPerSize = 1e-3;
// Leaves reach beyond the surface: shallower contact has the force of their gaps.
constexpr double kLeastDepthOfLeaves = 1e-3;
// Area that a weight presses on where no solver raises k, at least, as a share of the square of the size: a body that only just touches
// would be hit by an endless stiffness.
constexpr double kLeastAreaPerSize = 0.01;
constexpr double kWaterDensity = 1000;  // [kg/m^3]
// Nothing leaves contact faster than 1 / dissipation. Where gravity has larger numbers, as in a world of centimetres, so have speeds.
constexpr double kGravityOfEarth = 9.81;  // [m/s^2]

/// Mass of all links that can move, because any one of them may carry the others.
double massOf(const btMultiBody& multiBody)
{
	double mass = multiBody.isBaseStaticOrKinematic() ? 0 : double(multiBody.getBaseMass());
	for (int i = 0; i < multiBody.getNumLinks(); ++i) mass += double(multiBody.getLinkMass(i));
	return mass;
}

/// Mass of an object; zero if the solver cannot move it.
double dynamicMass(const btCollisionObject* object)
{
	if (const auto* link = object ? btMultiBodyLinkCollider::upcast(object) : nullptr)
		return link->isStaticOrKinematicObject() ? 0 : massOf(*link->m_multiBody);
	const btRigidBody* body = object ? btRigidBody::upcast(object) : nullptr;
	if (!body || body->isStaticOrKinematicObject() || !(body->getInvMass() > 0)) return 0;
	return 1.0 / double(body->getInvMass());
}

/// Magnitude of the body's own gravity, or `otherwise` if it has none [m/s^2].
double gravityOf(const btCollisionObject* object, double otherwise)
{
	const btRigidBody* body = object ? btRigidBody::upcast(object) : nullptr;
	const double own = body ? double(body->getGravity().length()) : 0;
	return own > 0 ? own : otherwise;
}

/// Whether the sums are those of leaves: a body has no surface, a coarser level answered, or B is round and in closed form.
bool pressesByLeaves(const btISTContact& contact) { return !(contact.total.surfaceVolume > 0); }

/// Error of a depth on a body's surface, that of single precision included [m].
double depthError(const ist::InnerSphereTree* tree)
{
	return tree ? std::hypot(double(tree->surface.tables.typicalError), ist::depthRounding(tree->surface)) : 0;
}

/// Length that depths are shares of [m]. `size` [m] is that of the smaller body.
double depthScale(const btISTContact& contact, double size) { return std::min(size, kSizePerThickness * contact.thickness()); }

/// Mean depth at which the pair shall rest [m].
double aimedDepth(const btISTContact& contact, double size)
{
	const double depth = kDepthPerSize * depthScale(contact, size),
				 most = std::min(kMostDepthPerSize * size, kMostDepthPerThickness * contact.thickness());
	if (!pressesByLeaves(contact))
	{
		const double error = std::hypot(depthError(contact.treeA.get()), depthError(contact.treeB.get())),
					 mostOnBumps = std::max(kDepthOnBumpsPerSize * size, kDepthOnBumpsPerThickness * contact.thickness());
		return std::min(std::max(depth, std::min(kDepthPerError * error, mostOnBumps)), most);
	}
	const double gap = contact.treeA->errorLength() + (contact.treeB ? contact.treeB->errorLength() : 0);
	return std::min(std::max(gap, kLeastDepthOfLeaves * size), most);
}

double sizeOfSmaller(const btISTContact& contact)
{
	return std::cbrt(std::min(contact.treeA->volume, contact.treeB ? contact.treeB->volume : contact.volumeB));
}
}  // namespace

void setStiffnessForArea(btISTContact& contact)
{
	btISTPairConstants& constants = contact.constants;
	if (constants.rule != btISTStiffnessRule::OwnLoad) return;
	const double size = sizeOfSmaller(contact), all = size * size;
	const ist::SymmetricMatrix6 K = ist::pressureStiffness(contact.total, {1, constants.weightA, constants.weightB});
	const double area = K(0, 0) + K(1, 1) + K(2, 2);
	constants.k = constants.load / (constants.depth * std::clamp(area, kLeastAreaPerSize * all, all));
}

bool btISTContact::supposesOthers() const
{
	const auto isGiven = [](const ist::Twist& t) { return squaredNorm(t.linear) + squaredNorm(t.angular) > 0; };
	return isGiven(supposedA) || isGiven(supposedB);
}

double btISTContact::thickness() const
{
	return std::min(ist::thicknessOf(*treeA), treeB ? ist::thicknessOf(*treeB) : std::numeric_limits<double>::infinity());
}

btISTPairConstants btISTDefaultPairRule::decide(
	const btISTContact& contact, const btCollisionObject* bodyA, const btCollisionObject* bodyB) const
{
	const double size = sizeOfSmaller(contact);
	const double gravityA = gravityOf(bodyA, m_gravity), gravityB = gravityOf(bodyB, m_gravity);
	double load = std::max(dynamicMass(bodyA) * gravityA, dynamicMass(bodyB) * gravityB);
	if (!(load > 0)) load = kWaterDensity * size * size * size * m_gravity;

	btISTPairConstants constants;
	constants.load = load;
	constants.freeRolling = true;
	constants.depth = aimedDepth(contact, size);
	const double first = std::max(constants.depth, kFirstDepthPerSize * depthScale(contact, size));
	constants.gravity = std::max(gravityA, gravityB);
	constants.dissipation *= std::min(1.0, kGravityOfEarth / constants.gravity);
	constants.rule = btISTStiffnessRule::OwnLoad;
	constants.k = load / (first * size * size);
	if (contact.halfSpace)
	{
		constants.weightA = 0;
		constants.weightB = 1;
	}
	return constants;
}

void btISTContactStore::count(btISTContact& contact, const ist::OverlapResult* result, double seconds)
{
	addQueryTime(seconds);
	for (btISTQueryCost* cost : {&contact.cost, &m_cost})
	{
		cost->seconds += seconds;
		cost->asked += contact.use == btISTCachedResult::Ask;
		cost->cachedApart += contact.use == btISTCachedResult::Apart;
		cost->cachedStill += contact.use == btISTCachedResult::Still;
		cost->cachedMoved += contact.use == btISTCachedResult::Moved;
		if (!result) continue;
		cost->querySeconds += seconds;
		cost->largestCacheError = std::max(cost->largestCacheError, contact.kept.foundError());
		cost->nodeVisits += result->nodeVisits;
		cost->ballTests += result->ballTests;
		cost->leafPairs += result->total.pairs;
	}
}

btISTContactStore::btISTContactStore() = default;
btISTContactStore::~btISTContactStore() = default;

btISTContact* btISTContactStore::find(const btPersistentManifold* manifold)
{
	const auto found = m_index.find(manifold);
	return found == m_index.end() ? nullptr : m_active[found->second];
}

const btISTContact* btISTContactStore::find(const btPersistentManifold* manifold) const
{
	return const_cast<btISTContactStore*>(this)->find(manifold);
}

btISTContact* btISTContactStore::acquire(const btPersistentManifold* manifold)
{
	if (m_free.empty())
	{
		m_pool.push_back(std::make_unique<btISTContact>());
		m_free.push_back(m_pool.back().get());
	}
	btISTContact* contact = m_free.back();
	m_free.pop_back();
	*contact = btISTContact();
	contact->manifold = manifold;
	m_index[manifold] = m_active.size();
	m_active.push_back(contact);
	return contact;
}

void btISTContactStore::release(const btPersistentManifold* manifold)
{
	const auto found = m_index.find(manifold);
	if (found == m_index.end()) return;
	const size_t at = found->second;
	btISTContact* contact = m_active[at];
	m_index.erase(found);
	if (m_active.back() != contact)
	{
		m_active[at] = m_active.back();
		m_index[m_active[at]->manifold] = at;
	}
	m_active.pop_back();
	// Trees are large; a pooled entry must not keep them alive.
	contact->treeA.reset();
	contact->memory.reset();
	contact->treeB.reset();
	contact->manifold = nullptr;
	m_free.push_back(contact);
}
