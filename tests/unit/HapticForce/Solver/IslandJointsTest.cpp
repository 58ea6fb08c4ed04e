// SPDX-License-Identifier: Zlib
#include "tests/unit/HapticForce/Solver/IslandScene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

using namespace island;

namespace
{
struct JointedScene : Scene
{
	std::vector<btIslandJointRow> rows;

	explicit JointedScene(uint64_t seed) : Scene(seed)
	{
		const double ratio = std::pow(10.0, double(seed % 4));
		const int count = 2 + int(seed % 7);
		for (int i = 0; i < count; ++i) addBody(i % 2 ? ratio : 1);
		for (int i = 0; i < 2 * count; ++i)
		{
			btIslandJointRow row;
			row.body[0] = i % count;
			row.body[1] = i < count ? i - 1 : -1;
			for (auto& side : row.jacobian)
				for (double& x : side) x = uniform(-1, 1);
			row.wanted = uniform(-1, 1);
			row.compliance = i % 3 == 0 ? uniform(0, 0.1) : 0;
			// Joints, limits and motors.
			row.lower = i % 3 == 0 ? -1e30 : i % 3 == 1 ? 0 : -uniform(0, 0.3);
			row.upper = i % 3 == 2 ? uniform(0, 0.3) : 1e30;
			rows.push_back(row);
		}
	}
	/// Velocity of a row after the impulses.
	double velocity(const btIslandJointRow& row, const std::vector<double>& impulses) const
	{
		double sum = 0;
		for (int side = 0; side < 2; ++side)
		{
			if (row.body[side] < 0) continue;
			const btVolumetricRowBody& b = bodies[size_t(row.body[side])];
			ist::Twist v = free[size_t(row.body[side])];
			for (size_t i = 0; i < rows.size(); ++i)
				for (int k = 0; k < 2; ++k)
				{
					if (rows[i].body[k] != row.body[side]) continue;
					const double* J = rows[i].jacobian[k];
					v.linear += impulses[i] * b.inverseMass.x * ist::Vec3{J[0], J[1], J[2]};
					v.angular += impulses[i] * (b.inverseInertia * ist::Vec3{J[3], J[4], J[5]});
				}
			const double* J = row.jacobian[side];
			sum += dot({J[0], J[1], J[2]}, v.linear) + dot({J[3], J[4], J[5]}, v.angular);
		}
		return sum;
	}
};
}  // namespace

// A row within its limits has its velocity, and one at a limit is on the right side of it.
TEST(btIslandJoints, RowsHaveTheirVelocityOrTheirLimit)
{
	int within = 0, limited = 0;
	for (uint64_t seed = 1; seed <= 200; ++seed)
	{
		const JointedScene scene(seed);
		btIslandBlockSolver solver;
		for (const btVolumetricRowBody& b : scene.bodies) solver.addBody(b);
		for (const btIslandJointRow& row : scene.rows) solver.addJointRow(row);
		ASSERT_TRUE(solver.solve(scene.free.data()));
		std::vector<double> impulses;
		for (size_t i = 0; i < scene.rows.size(); ++i) impulses.push_back(solver.jointImpulse(int(i)));
		for (size_t i = 0; i < scene.rows.size(); ++i)
		{
			const btIslandJointRow& row = scene.rows[i];
			const double missing = row.wanted - scene.velocity(row, impulses) - row.compliance * impulses[i];
			ASSERT_GE(impulses[i], row.lower);
			ASSERT_LE(impulses[i], row.upper);
			const bool atLower = impulses[i] == row.lower, atUpper = impulses[i] == row.upper;
			++(atLower || atUpper ? limited : within);
			EXPECT_LT(atUpper ? 0 : missing, 1e-5) << "seed " << seed << ", row " << i;
			EXPECT_GT(atLower ? 0 : missing, -1e-5) << "seed " << seed << ", row " << i;
		}
	}
	EXPECT_GT(within, 500);
	EXPECT_GT(limited, 300);
}

// Two rows that want different velocities in one direction share the difference, and stay finite.
TEST(btIslandJoints, RowsThatContradictEachOtherMeetInTheMiddle)
{
	JointedScene scene(5);
	btIslandBlockSolver solver;
	solver.addBody(scene.bodies[0]);
	for (const double wanted : {1.0, 3.0})
	{
		btIslandJointRow row;
		row.body[0] = 0;
		row.jacobian[0][1] = 1;
		row.wanted = wanted;
		row.lower = -1e30;
		row.upper = 1e30;
		solver.addJointRow(row);
	}
	ASSERT_TRUE(solver.solve(scene.free.data()));
	const double moved = (solver.jointImpulse(0) + solver.jointImpulse(1)) * scene.bodies[0].inverseMass.y;
	EXPECT_NEAR(scene.free[0].linear.y + moved, 2, 1e-3);
}
