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
/// The larger of the two. Unlike std::max it keeps what is not a number, so that no world that has blown up looks well.
inline double larger(double a, double b) { return std::isnan(a) || b <= a ? a : b; }

/// One pair in one step, volumetric or Bullet's own; of compounds, one pair of their parts.
struct ContactRecord
{
	double time = 0;  ///< at the end of the step, from the beginning of the log [s]
	const btCollisionObject* a = nullptr;
	const btCollisionObject* b = nullptr;
	bool volumetric = false;
	double volume = 0;  ///< of the overlap [m^3]; 0 for Bullet's own
	/// Volumetric: depth in A plus depth in B, in the mean over the overlap: how far the surfaces have passed each other, where the contact
	/// is flat. Bullet's own: of the deepest point. Never negative [m].
	double depth = 0;
	Vec3 impulseOnA;  ///< of the solver in this step, World [N s]
	double slip = 0;  ///< way of A along B in this step, in the middle of the contact, across its normal [m]
};

/// What touched what, how deeply, how hard, and how far it slid. Pairs that sleep are not in it. Grows with every step: for tests.
class ContactLog
{
public:
	/// Both must outlive it.
	ContactLog(const btDiscreteDynamicsWorld& world, const btISTContactStore& store) : m_world(world), m_store(store) {}

	/// Once after each internal step, of `h` [s]: of a `stepSimulation` that makes several, only the last would be seen.
	void record(double h);
	/// Begins anew.
	void clear();

	const std::vector<ContactRecord>& records() const { return m_records; }
	/// Over all records of the body, or of all bodies: the largest depth [m]. Not a number, as `slip`, once any body of the world was
	/// nowhere: Bullet takes it out of contact.
	double deepest(const btCollisionObject* body = nullptr) const;
	/// The longest way that one of the body's pairs, or any pair, slid in all [m]; where several parts of a pair touch in a step, that of
	/// the part that slid farthest in it.
	double slip(const btCollisionObject* body = nullptr) const;
	/// The sum of what contacts did to the body, World [N s].
	Vec3 impulseOn(const btCollisionObject* body) const;
	/// Whether the two were ever in contact.
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
