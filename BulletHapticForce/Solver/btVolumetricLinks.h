// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Solver/btContactEnergyTank.h"
#include "BulletHapticForce/Solver/btVolumetricRows.h"
#include "BulletHapticForce/Solver/btVolumetricStatistics.h"

#include "BulletDynamics/Featherstone/btMultiBodyConstraint.h"

#include <vector>

class btMultiBody;
struct btSolverBody;

/// Volumetric contacts with at least one link of a btMultiBody. Each patch is a btVolumetricRow. Its response J M^-1 J^T uses the links'
/// own Jacobians (Featherstone's algorithm, as in Bullet's own rows). It is visited in each of Bullet's iterations, beside the rows of
/// joints and motors. The patches are solved one at a time, so the limits of iterations apply to links.
///
/// A row of a joint or motor that moves the links of a patch is visited once more in each iteration, together with the patch that bears
/// most of its impulse (Loaded). Without that, an iteration would add no more than the impulse that moves the unloaded links.
///
/// `bodies` is Bullet's pool of solver bodies, and `data` that of its multibody solver. Allocates nothing after the largest scene has
/// been seen.
class btVolumetricLinks
{
public:
	/// One side of a contact: a link of a multibody (-1: its base), or a body of the pool.
	struct Side
	{
		btMultiBody* multiBody = nullptr;
		int link = -1;
		int body = 0;
	};

	/// A row of Bullet's multibody solver, and the patch that bears most of its impulse.
	struct Loaded
	{
		int row = 0, patch = 0;
		double stiffening = 1;  ///< effective mass of the row with the patch in place, over that of the row alone
	};

	void clear();
	bool isEmpty() const { return m_entries.empty(); }
	/// Tells the joints of this step, among them the motors that may press. Call it before the first `add`.
	void setJoints(btMultiBodyConstraint* const* joints, int count);
	/// Adds all patches of a contact. `h` is the step [s]. Contacts and patches that exert no force are counted in `statistics`.
	void add(btISTContact& contact, const Side& a, const Side& b, const btContactFriction& friction, double h, const btSolverBody* bodies,
		btMultiBodyJacobianData& data, btVolumetricStatistics& statistics);
	/// Appends the bodies of the pool that these rows move.
	void appendTouched(std::vector<int>& touched) const;
	/// Finds the rows that move the links of patches. Call it after the last `add`.
	void findLoaded(const btMultiBodyConstraintArray& rows, const btMultiBodyJacobianData& data);
	const std::vector<Loaded>& loaded() const { return m_loaded; }
	/// Visits one patch. Returns the squared change of its force impulse [N^2 s^2].
	double visit(int patch, btSolverBody* bodies, btMultiBodyJacobianData& data);
	bool pushes(int patch) const { return m_entries[size_t(patch)].normalImpulse > 0; }
	/// Visits every patch once. Returns the largest squared change of a force impulse [N^2 s^2].
	double iterate(btSolverBody* bodies, btMultiBodyJacobianData& data);
	/// Adds to each body's twist the change by all these patches.
	void sumChanges(const btSolverBody* bodies, const btMultiBodyJacobianData& data, std::vector<ist::Twist>& change);
	/// Limits every contact to its energy tank. Writes the impulses into the contacts and, for joint feedback, into the multibodies.
	/// `change` is the change of each body's twist by all volumetric contacts.
	void finish(btSolverBody* bodies, btMultiBodyJacobianData& data, std::vector<ist::Twist>& change, btVolumetricStatistics& statistics);

private:
	struct PlacedSide : Side
	{
		int dofs = 0;
		int velocity = 0;     // index of its first velocity among the solver's velocities of multibodies
		size_t jacobian = 0;  // index of its first number in m_jacobians: six rows of J (force, then moment), then six of M^-1 J^T
	};
	struct Entry
	{
		btISTContact* contact = nullptr;
		int patchIndex = 0;
		btContactPatch patch;
		PlacedSide side[2];
		btVolumetricRow row;
		ist::Wrench impulse, elastic;
		double normalImpulse = 0;
	};
	/// Twists of the sides that are bodies, and velocities of all multibodies.
	struct Motion
	{
		ist::Twist body[2];
		std::vector<double> links;
	};

	PlacedSide place(const Side& side, const ist::Vec3& point, btMultiBodyJacobianData& data);
	/// Change of a degree of freedom's velocity by an impulse at the patch, force first.
	double responseOf(const PlacedSide& side, int dof, const double* impulse) const;
	void addResponse(const Entry& e, const ist::Wrench& impulse, const btSolverBody* bodies, Motion& motion) const;
	double motorForce(const Entry& e) const;
	static void leaveOutRolling(Entry& e, const ist::Vec3& spin, double h);
	ist::Twist relative(const Entry& e, const btSolverBody* bodies, const Motion& motion) const;
	ist::SymmetricMatrix6 responseOf(const Entry& e, const btSolverBody* bodies);
	const Motion& state(const Entry& e, const btSolverBody* bodies, const btMultiBodyJacobianData& data);
	void apply(const Entry& e, const ist::Wrench& impulse, btSolverBody* bodies, btMultiBodyJacobianData& data) const;
	void holdToEnergyTank(size_t first, int count, btSolverBody* bodies, btMultiBodyJacobianData& data, std::vector<ist::Twist>& change,
		btVolumetricStatistics& statistics);
	ist::Twist responseTo(const btMultiBodySolverConstraint& row, const Entry& e, const btMultiBodyJacobianData& data) const;
	void writeFeedback(const Entry& e) const;

	double m_step = 0;
	btMultiBodyConstraint* const* m_joints = nullptr;
	int m_jointCount = 0;
	std::vector<Entry> m_entries;
	std::vector<Loaded> m_loaded;
	std::vector<double> m_jacobians;
	Motion m_motion, m_own;
	std::vector<double> m_changed;  // change of the multibodies' velocities by all volumetric contacts
};
