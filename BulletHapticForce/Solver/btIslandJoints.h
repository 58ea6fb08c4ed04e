// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Solver/btEnvelopeFactor.h"

#include <vector>

/// A row of a joint or motor: the impulse L within its limits that gives the row the velocity J v = wanted - compliance L.
struct btIslandJointRow
{
	int body[2] = {-1, -1};       ///< indices of the bodies; -1 for an immovable one
	double jacobian[2][6] = {};   ///< derivative of the row's velocity by each body's twist at its centre of mass, World axes
	double wanted = 0;            ///< [m/s], or [rad/s]
	double compliance = 0;        ///< [1/kg], or [1/(kg m^2)]
	double lower = 0, upper = 0;  ///< limits of the impulse [N s], or [N m s]
};

/// The rows of all joints in an island (btIslandBlockSolver). A row is a stiff damper in the factor of the island, and its impulse is
/// L = clamp((L0 + S (wanted - J v)) / (1 + S compliance)), the method of multipliers. A row at a limit exerts that limit, and leaves the
/// factor. `refine` sets L0 = L, which makes the damper as hard as the row. Rows that contradict each other share the difference; their
/// impulses grow by S times the difference in each refinement.
///
/// `z` is the state of the island: twists are v = free + R z with the root R of the inverse mass, 6 numbers for each place. `free` has 6
/// numbers for each body.
class btIslandJoints
{
public:
	void clear() { m_rows.clear(); }
	/// `roots` are the R of the two bodies, row major; null for an immovable one.
	void add(const btIslandJointRow& row, const double* const (&roots)[2]);
	bool isEmpty() const { return m_rows.empty(); }
	int count() const { return int(m_rows.size()); }
	const int* bodies(int row) const { return m_rows[size_t(row)].given.body; }
	/// Sets the place of each body in the factor: `placeOf(body)`.
	template <class PlaceOf> void setPlaces(const PlaceOf& placeOf)
	{
		for (Row& r : m_rows)
			for (int side = 0; side < 2; ++side) r.place[side] = r.given.body[side] < 0 ? -1 : placeOf(r.given.body[side]);
	}
	/// Sets the stiffness of the dampers. `heaviest` is the largest mass that the rows may have to hold [kg].
	void setStiffness(double heaviest);
	void couple(btEnvelopeFactor& factor) const;
	void addTo(btEnvelopeFactor& factor) const;
	/// Adds the rows' part of the right-hand side.
	void addRest(const double* free, double* rest) const;
	/// Begins a search for the rows at their limits.
	void beginSearch();
	/// Computes the impulses, and moves rows to their limits or back. Returns false when no row has to move, which ends the search. It
	/// moves all rows at once while that helps, and then the last one alone, which cannot cycle (Judice and Pires, 1994).
	bool changeActiveSet(const double* free, const double* z);
	/// Computes the impulses, and returns true when they agree with the limits.
	bool isSettled(const double* free, const double* z);
	/// Returns true when the impulses have changed, and another solve makes them more exact.
	bool refine();
	void setZero();
	double impulse(int row) const { return m_rows[size_t(row)].impulse; }

private:
	enum class State
	{
		Free,
		Lower,
		Upper,
		Idle  // the search has not ended: exerts nothing, or the limit next to it
	};
	struct Row
	{
		btIslandJointRow given;
		int place[2] = {-1, -1};
		double jacobian[2][6] = {};  // J R
		double response = 0;         // J R R^T J^T: change of the row's velocity by a unit impulse
		double lightest = 0;         // mass of the lighter body that has one [kg]
		double stiffness = 0;        // S
		double impulse = 0, former = 0;
		State state = State::Free;

		double softening() const { return 1 / (1 + stiffness * given.compliance); }
		double limit() const;
	};
	static double velocity(const Row& row, const double* free);
	/// State in which the row would be by its velocity; sets its impulse.
	static State aim(Row& row, const double* free, const double* z);

	int m_fewest = 0, m_patience = 0, m_rounds = 0;
	std::vector<Row> m_rows;
};
