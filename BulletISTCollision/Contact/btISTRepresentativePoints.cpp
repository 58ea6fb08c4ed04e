// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Contact/btISTRepresentativePoints.h"

#include "BulletISTCollision/Registry/btISTConversion.h"

#include "BulletCollision/CollisionDispatch/btCollisionObject.h"
#include "BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h"
#include "BulletCollision/CollisionDispatch/btManifoldResult.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace
{
// Points deeper than 0.04 m (btContactSolverInfo::m_splitImpulsePenetrationThreshold) are taken out of Bullet's velocity solve, and a
// heavy body then falls through. Deeper contact is written with this distance and the stiffness that gives the same force.
constexpr double kDeepestDistance = 0.03;  // [m]
// Patches whose forces differ by less than this angle become one group. Then four points of one normal lose 6 % of the force at most.
const double kSameDirection = std::cos(20 * std::numbers::pi / 180);

/// Patches that push in about the same direction. A's mesh frame.
struct PatchGroup
{
	ist::OverlapIntegrals sums;
	ist::Wrench wrench;   // about A's origin
	double strength = 0;  // |force|
};

class PatchGroups
{
public:
	explicit PatchGroups(const btISTContact& contact) : m_pair{contact.constants.k, contact.constants.weightA, contact.constants.weightB}
	{
		for (int i = 0; i < contact.patchCount; ++i) add(contact.patches[i]);
		while (m_count > MANIFOLD_CACHE_SIZE) mergeWeakest();
	}
	int count() const { return m_count; }
	const PatchGroup& operator[](int i) const { return m_group[i]; }
	const ist::PressurePair& pair() const { return m_pair; }

private:
	void refresh(PatchGroup& g) const
	{
		g.wrench = ist::pressureWrench(g.sums, m_pair);
		g.strength = ist::norm(g.wrench.force);
	}

	int closest(const PatchGroup& g, int except, double& cosine) const
	{
		int best = -1;
		cosine = -2;
		for (int i = 0; i < m_count; ++i)
		{
			const double c = ist::dot(ist::normalized(m_group[i].wrench.force), ist::normalized(g.wrench.force));
			if (i != except && c > cosine) best = i, cosine = c;
		}
		return best;
	}

	void add(const ist::OverlapIntegrals& patch)
	{
		PatchGroup g;
		g.sums = patch;
		refresh(g);
		if (!(g.strength > 0) || !(g.sums.volume > 0)) return;
		double cosine;
		const int near = closest(g, -1, cosine);
		if (near < 0 || cosine < kSameDirection)
		{
			m_group[m_count++] = g;
			return;
		}
		m_group[near].sums.add(patch);
		refresh(m_group[near]);
	}

	void mergeWeakest()
	{
		int weakest = 0;
		for (int i = 1; i < m_count; ++i)
			if (m_group[i].strength < m_group[weakest].strength) weakest = i;
		double cosine;
		const int into = closest(m_group[weakest], weakest, cosine);
		m_group[into].sums.add(m_group[weakest].sums);
		refresh(m_group[into]);
		m_group[weakest] = m_group[--m_count];
	}

	ist::PressurePair m_pair;
	PatchGroup m_group[btISTContact::kMaxPatches];
	int m_count = 0;
};

/// A group described in its own plane: centre, normal, in-plane axes, and second moments of the overlap. A's mesh frame.
struct GroupPlane
{
	ist::Vec3 center, normal, t1, t2;
	double xx = 0, xy = 0, yy = 0;  // [m^2]
	double force = 0, stiffness = 0;
	double moment1 = 0, moment2 = 0;  // about `center`, along t1 and t2

	GroupPlane(const PatchGroup& g, const ist::PressurePair& pair, const ist::Vec3& origin)
	{
		const ist::Vec3 c = g.sums.firstMoment / g.sums.volume;
		center = origin + c;
		normal = ist::normalized(g.wrench.force);
		force = g.strength;
		ist::completeFrame(normal, t1, t2);
		const double* s = g.sums.secondMoment;
		const ist::Mat3 second{{{s[0], s[3], s[4]}, {s[3], s[1], s[5]}, {s[4], s[5], s[2]}}};
		const auto covariance = [&](const ist::Vec3& u, const ist::Vec3& v) {
			return ist::dot(u, second * v) / g.sums.volume - ist::dot(u, c) * ist::dot(v, c);
		};
		xx = std::max(covariance(t1, t1), 0.0);
		yy = std::max(covariance(t2, t2), 0.0);
		xy = covariance(t1, t2);
		const ist::Vec3 moment = g.wrench.torque - ist::cross(c, g.wrench.force);
		moment1 = ist::dot(moment, t1);
		moment2 = ist::dot(moment, t2);

		const ist::SymmetricMatrix6 K = ist::pressureStiffness(g.sums, pair);
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j) stiffness += normal[i] * K(i, j) * normal[j];
		// Deep contact may soften, but a point needs a positive stiffness.
		const double least = 0.1 * pair.stiffness * ist::norm(g.sums.areaVector);
		if (!(stiffness > least)) stiffness = least;
	}
};

void append(btISTRepresentativePoints& out, const GroupPlane& g, const ist::Pose& X_WA, double x, double y, double force, double stiffness)
{
	if (!(stiffness > 0) || !(force >= 0) || out.count >= MANIFOLD_CACHE_SIZE) return;
	btISTRepresentativePoint& p = out.point[out.count++];
	p.position = X_WA * (g.center + x * g.t1 + y * g.t2);
	p.normal = X_WA.rotation * g.normal;
	p.force = force;
	p.stiffness = stiffness;
}

// Four points at the centre +- the columns of S, where S S^T = 2 covariance. Each has a quarter of the stiffness, so total, first and
// second moments are exact. S is the symmetric root; principal axes would spin when the overlap is nearly isotropic. The forces are a
// quarter each plus the antisymmetric part that makes the moment; they are never negative.
void appendFour(btISTRepresentativePoints& out, const GroupPlane& g, const ist::Pose& X_WA)
{
	const double root = std::sqrt(std::max(g.xx * g.yy - g.xy * g.xy, 0.0));
	const double trace = std::sqrt(g.xx + g.yy + 2 * root);
	const double scale = trace > 0 ? std::sqrt(2.0) / trace : 0;
	const double x1 = scale * (g.xx + root), y1 = scale * g.xy, x2 = y1, y2 = scale * (g.yy + root);
	const double determinant = x1 * y2 - x2 * y1;
	const double quarter = g.force / 4;
	double f1 = 0, f2 = 0;
	if (determinant > 1e-12 * (x1 * x1 + y2 * y2))
	{
		// sum f y = moment1, -sum f x = moment2
		f1 = (-g.moment2 * y2 - g.moment1 * x2) / (2 * determinant);
		f2 = (g.moment1 * x1 + g.moment2 * y1) / (2 * determinant);
	}
	f1 = std::clamp(f1, -quarter, quarter);
	f2 = std::clamp(f2, -quarter, quarter);
	append(out, g, X_WA, x1, y1, quarter + f1, g.stiffness / 4);
	append(out, g, X_WA, -x1, -y1, quarter - f1, g.stiffness / 4);
	append(out, g, X_WA, x2, y2, quarter + f2, g.stiffness / 4);
	append(out, g, X_WA, -x2, -y2, quarter - f2, g.stiffness / 4);
}

// Two points on the longer principal axis. The moment about the other axis is lost.
void appendTwo(btISTRepresentativePoints& out, const GroupPlane& g, const ist::Pose& X_WA)
{
	const double mean = (g.xx + g.yy) / 2, half = (g.xx - g.yy) / 2;
	const double angle = 0.5 * std::atan2(g.xy, half);
	const double length = std::sqrt(mean + std::hypot(half, g.xy));
	const double x = length * std::cos(angle), y = length * std::sin(angle);
	double f = length > 0 ? (g.moment1 * std::sin(angle) - g.moment2 * std::cos(angle)) / (2 * length) : 0;
	f = std::clamp(f, -g.force / 2, g.force / 2);
	append(out, g, X_WA, x, y, g.force / 2 + f, g.stiffness / 2);
	append(out, g, X_WA, -x, -y, g.force / 2 - f, g.stiffness / 2);
}

// Beyond the medial axis the field's force vanishes while the bodies still overlap. A contact test must report the overlap all the same.
void appendTouch(btISTRepresentativePoints& out, const btISTContact& contact)
{
	ist::Vec3 normal = ist::normalized(contact.total.areaVector);
	if (ist::norm(normal) == 0) normal = {0, 0, 1};
	btISTRepresentativePoint& p = out.point[out.count++];
	p.position = contact.X_WA * (contact.treeA->origin + contact.total.firstMoment / contact.total.volume);
	p.normal = contact.X_WA.rotation * normal;
	p.force = 0;
	p.stiffness = contact.constants.k * std::cbrt(contact.total.volume * contact.total.volume);
}

bool isGhost(const btCollisionObject* object) { return (object->getInternalType() & btCollisionObject::CO_GHOST_OBJECT) != 0; }

/// Bullet's point for `p`. The positions on the two bodies lie half the depth to either side.
btManifoldPoint manifoldPoint(
	const btISTRepresentativePoint& p, double dissipation, const btCollisionObjectWrapper* wrapA, const btCollisionObjectWrapper* wrapB)
{
	const btCollisionObject* a = wrapA->getCollisionObject();
	const btCollisionObject* b = wrapB->getCollisionObject();
	// Code that moves a ghost, such as a character controller, needs the whole depth.
	const double depth = isGhost(a) || isGhost(b) ? p.depth() : std::min(p.depth(), kDeepestDistance);
	const btVector3 onA = toBullet(p.position - (depth / 2) * p.normal), onB = toBullet(p.position + (depth / 2) * p.normal);
	btManifoldPoint m(a->getWorldTransform().invXform(onA), b->getWorldTransform().invXform(onB), toBullet(p.normal), btScalar(-depth));
	m.m_positionWorldOnA = onA;
	m.m_positionWorldOnB = onB;
	m.m_partId0 = wrapA->m_partId;
	m.m_index0 = wrapA->m_index;
	m.m_partId1 = wrapB->m_partId;
	m.m_index1 = wrapB->m_index;
	m.m_combinedFriction = gCalculateCombinedFrictionCallback(a, b);
	m.m_combinedRestitution = gCalculateCombinedRestitutionCallback(a, b);
	m.m_combinedRollingFriction = gCalculateCombinedRollingFrictionCallback(a, b);
	m.m_combinedSpinningFriction = gCalculateCombinedSpinningFrictionCallback(a, b);
	btPlaneSpace1(m.m_normalWorldOnB, m.m_lateralFrictionDir1, m.m_lateralFrictionDir2);
	m.m_contactPointFlags |= BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING;
	m.m_combinedContactStiffness1 = btScalar(depth > 0 ? p.force / depth : p.stiffness);
	m.m_combinedContactDamping1 = btScalar(dissipation * p.force);
	return m;
}

/// Matches each point of the manifold with the nearest new point that is still free, or with -1.
void matchPoints(const btPersistentManifold& manifold, const btManifoldPoint* points, int count, int (&slotOf)[MANIFOLD_CACHE_SIZE])
{
	bool taken[MANIFOLD_CACHE_SIZE] = {};
	std::fill(slotOf, slotOf + MANIFOLD_CACHE_SIZE, -1);
	for (int round = 0; round < std::min(count, manifold.getNumContacts()); ++round)
	{
		int bestPoint = -1, bestSlot = -1;
		btScalar best = BT_LARGE_FLOAT;
		for (int i = 0; i < count; ++i)
			for (int slot = 0; slot < manifold.getNumContacts(); ++slot)
			{
				if (slotOf[i] >= 0 || taken[slot]) continue;
				const btScalar d = manifold.getContactPoint(slot).m_localPointA.distance2(points[i].m_localPointA);
				if (bestPoint >= 0 && d >= best) continue;
				best = d;
				bestPoint = i;
				bestSlot = slot;
			}
		slotOf[bestPoint] = bestSlot;
		taken[bestSlot] = true;
	}
}

void announceAdded(btPersistentManifold& manifold, int slot, const btCollisionObjectWrapper* wrapA, const btCollisionObjectWrapper* wrapB)
{
	const int flags = wrapA->getCollisionObject()->getCollisionFlags() | wrapB->getCollisionObject()->getCollisionFlags();
	if (!gContactAddedCallback || !(flags & btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK)) return;
	btManifoldPoint& p = manifold.getContactPoint(slot);
	(*gContactAddedCallback)(p, wrapA, p.m_partId0, p.m_index0, wrapB, p.m_partId1, p.m_index1);
}
}  // namespace

btISTRepresentativePoints::btISTRepresentativePoints(const btISTContact& contact)
{
	// Returns early, because most pairs do not touch and groups are large objects.
	if (!(contact.total.volume > 0)) return;
	const PatchGroups groups(contact);
	for (int i = 0; i < groups.count(); ++i)
	{
		const GroupPlane plane(groups[i], groups.pair(), contact.treeA->origin);
		if (groups.count() == 1) appendFour(*this, plane, contact.X_WA);
		else if (groups.count() == 2) appendTwo(*this, plane, contact.X_WA);
		else append(*this, plane, contact.X_WA, 0, 0, plane.force, plane.stiffness);
	}
	if (count == 0) appendTouch(*this, contact);
}

// The manifold is updated in place. Clearing it would signal the end and a new begin of the contact, and lose warm starting and user
// pointers.
void btISTRepresentativePoints::write(
	btPersistentManifold& manifold, double dissipation, const btCollisionObjectWrapper* wrapA, const btCollisionObjectWrapper* wrapB) const
{
	if (count == 0 && manifold.getNumContacts() == 0) return;
	btManifoldPoint fresh[MANIFOLD_CACHE_SIZE];
	for (int i = 0; i < count; ++i) fresh[i] = manifoldPoint(point[i], dissipation, wrapA, wrapB);
	int slotOf[MANIFOLD_CACHE_SIZE];
	const bool begins = manifold.getNumContacts() == 0 && count > 0;
	matchPoints(manifold, fresh, count, slotOf);

	bool used[MANIFOLD_CACHE_SIZE] = {};
	for (int i = 0; i < count; ++i)
	{
		if (slotOf[i] < 0) continue;
		manifold.replaceContactPoint(fresh[i], slotOf[i]);
		++manifold.getContactPoint(slotOf[i]).m_lifeTime;
		used[slotOf[i]] = true;
		announceAdded(manifold, slotOf[i], wrapA, wrapB);
	}
	// Points are removed from the back, because removal moves the last point into the gap.
	for (int slot = manifold.getNumContacts() - 1; slot >= 0; --slot)
		if (!used[slot]) manifold.removeContactPoint(slot);
	for (int i = 0; i < count; ++i)
		if (slotOf[i] < 0) announceAdded(manifold, manifold.addManifoldPoint(fresh[i]), wrapA, wrapB);
	if (begins && gContactStartedCallback) gContactStartedCallback(&manifold);
}

// The result sorts its bodies by the manifold, and expects normal and position in the manifold's order.
void btISTRepresentativePoints::report(btManifoldResult& out) const
{
	for (int i = 0; i < count; ++i)
	{
		const btISTRepresentativePoint& p = point[i];
		out.addContactPoint(toBullet(p.normal), toBullet(p.position + (p.depth() / 2) * p.normal), btScalar(-p.depth()));
	}
}
