// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Solver/btContactEnergyTank.h"
#include "BulletHapticForce/Solver/btVolumetricRows.h"
#include "BulletHapticForce/Solver/btVolumetricStatistics.h"

#include <vector>

class btMultiBody;
struct btMultiBodyJacobianData;
struct btSolverBody;

/// Volumetric contacts of which at least one side is a link of a btMultiBody. Each patch is a btVolumetricRow whose response is
/// J M^-1 J^T by the links' own Jacobians (Featherstone's algorithm, as for Bullet's own rows), visited in each of Bullet's iterations
/// beside the rows of joints and motors. One patch at a time: what iterations cannot hold between links, these cannot either.
/// `bodies` is Bullet's pool of solver bodies, `data` that of its multibody solver. No allocation once the largest scene has been seen.
class btVolumetricLinks
{
public:
	/// One side of a contact: a link (-1: the base) of a multibody, or else a body of the pool.
	struct Side
	{
		btMultiBody* multiBody = nullptr;
		int link = -1;
		int body = 0;
	};

	void clear();
	bool isEmpty() const { return m_entries.empty(); }
	/// All patches of a contact. `h`: step [s]. Counts what exerts nothing.
	void add(btISTContact& contact, const Side& a, const Side& b, double friction, double h, const btSolverBody* bodies,
		btMultiBodyJacobianData& data, btVolumetricStatistics& statistics);
	/// The bodies of the pool that these rows move.
	void appendTouched(std::vector<int>& touched) const;
	/// One visit of every patch; returns the largest square of a change of force impulse [N^2 s^2].
	double iterate(btSolverBody* bodies, btMultiBodyJacobianData& data);
	/// Adds to each body's twist what all these patches changed in it.
	void sumChanges(const btSolverBody* bodies, const btMultiBodyJacobianData& data, std::vector<ist::Twist>& change);
	/// Holds every contact to its energy tank, writes the impulses into the contacts and, for joint feedback, into the multibodies.
	/// `change`: of each body by all volumetric contacts.
	void finish(btSolverBody* bodies, btMultiBodyJacobianData& data, std::vector<ist::Twist>& change, btVolumetricStatistics& statistics);

private:
	struct PlacedSide : Side
	{
		int dofs = 0;
		int velocity = 0;     // first index in the solver's velocities of multibodies
		size_t jacobian = 0;  // first index in m_jacobians: six rows of J (force, then moment), then six of M^-1 J^T
	};
	struct Entry
	{
		btISTContact* contact = nullptr;
		int patchIndex = 0;
		double friction = 0;
		btContactPatch patch;
		PlacedSide side[2];
		btVolumetricRow row;
		ist::Wrench impulse, elastic;
		double normalImpulse = 0;
	};
	/// Twists of the two sides that are bodies, and velocities of all multibodies.
	struct Motion
	{
		ist::Twist body[2];
		std::vector<double> links;
	};

	PlacedSide place(const Side& side, const ist::Vec3& point, btMultiBodyJacobianData& data);
	/// Change of a degree of freedom by an impulse at the patch, force first.
	double responseOf(const PlacedSide& side, int dof, const double* impulse) const;
	void addResponse(const Entry& e, const ist::Wrench& impulse, const btSolverBody* bodies, Motion& motion) const;
	ist::Twist relative(const Entry& e, const btSolverBody* bodies, const Motion& motion) const;
	ist::SymmetricMatrix6 responseOf(const Entry& e, const btSolverBody* bodies);
	const Motion& state(const Entry& e, const btSolverBody* bodies, const btMultiBodyJacobianData& data);
	void apply(const Entry& e, const ist::Wrench& impulse, btSolverBody* bodies, btMultiBodyJacobianData& data) const;
	void holdToEnergyTank(size_t first, int count, btSolverBody* bodies, btMultiBodyJacobianData& data, std::vector<ist::Twist>& change,
		btVolumetricStatistics& statistics);
	void writeFeedback(const Entry& e) const;

	double m_step = 0;
	std::vector<Entry> m_entries;
	std::vector<double> m_jacobians;
	Motion m_motion, m_own;
	std::vector<double> m_changed;  // of the multibodies by all volumetric contacts
};
