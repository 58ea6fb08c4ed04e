// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Contact/btISTContactStore.h"
#include "BulletISTCollision/Core/Base/Vec3.h"

#include <cmath>
#include <vector>

class btCollisionObject;
class btDiscreteDynamicsWorld;
class btPersistentManifold;

namespace ist::test
{
/// The larger of two numbers. Unlike std::max it returns NaN when `a` or `b` is NaN, so that a world that has blown up is not taken for a
/// good one.
inline double larger(double a, double b) { return std::isnan(a) || b <= a ? a : b; }

/// One pair of bodies in one step, with volumetric contact or Bullet's own. In compounds, one pair of their parts.
struct ContactRecord
{
	double time = 0;  ///< time at the end of the step, from the beginning of the log [s]
	const btCollisionObject* a = nullptr;
	const btCollisionObject* b = nullptr;
	bool volumetric = false;
	double volume = 0;  ///< volume of the overlap [m^3]; 0 for Bullet's own contact
	/// Depth [m], never negative. Volumetric contact: depth in A plus depth in B, averaged over the overlap; in flat contact, the
	/// distance by which the surfaces have passed each other. Bullet's own contact: depth of the deepest point.
	double depth = 0;
	Vec3 impulseOnA;  ///< impulse on A by the solver in this step, World [N s]
	double slip = 0;  ///< path of A along B in this step, at the middle of the contact, perpendicular to its normal [m]
};

/// Record of contacts: which bodies touched, how deeply, with which impulse, and how far they slid. Sleeping pairs are not recorded. The
/// log grows with every step; it is for tests.
class ContactLog
{
public:
	/// Both arguments must outlive the log.
	ContactLog(const btDiscreteDynamicsWorld& world, const btISTContactStore& store) : m_world(world), m_store(store) {}

	/// Records one step of `h` [s]. Call it after each internal step; after a `stepSimulation` with several steps only the last one would
	/// be seen.
	void record(double h);
	/// Deletes all records and restarts the time at 0.
	void clear();

	const std::vector<ContactRecord>& records() const { return m_records; }
	/// Largest depth over all records of the body, or of all bodies [m]. NaN, as is `slip`, once any body of the world had a pose that is
	/// not finite, because Bullet takes such a body out of contact.
	double deepest(const btCollisionObject* body = nullptr) const;
	/// Longest total path that any pair, or any pair of the body, has slid [m]. When several parts of a pair touch in a step, the part
	/// that slid farthest counts.
	double slip(const btCollisionObject* body = nullptr) const;
	/// Sum of the impulses of contacts on the body, World [N s].
	Vec3 impulseOn(const btCollisionObject* body) const;
	/// True when the two bodies were ever in contact.
	bool haveTouched(const btCollisionObject* a, const btCollisionObject* b) const;

private:
	void add(const btISTContact& contact, double h);
	void add(const btPersistentManifold& manifold, double h);

	const btDiscreteDynamicsWorld& m_world;
	const btISTContactStore& m_store;
	std::vector<ContactRecord> m_records;
	double m_time = 0;
	bool m_blownUp = false;
};
}  // namespace ist::test
