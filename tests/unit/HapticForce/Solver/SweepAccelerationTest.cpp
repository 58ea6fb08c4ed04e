// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Solver/btSweepAcceleration.h"

#include "tests/unit/CountingAllocator.h"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <random>

namespace
{
using Vector = Eigen::VectorXd;
constexpr int kUnknowns = 40;

/// Sweeps x -> M x + b whose slowest directions shrink by 3 % a sweep. Limited entries of x stay below 1.
struct Sweeps
{
	Eigen::MatrixXd M;
	Vector b, x = Vector::Zero(kUnknowns);
	bool limited;

	Sweeps(unsigned seed, bool isLimited) : limited(isLimited)
	{
		std::mt19937 random(seed);
		std::uniform_real_distribution<double> uniform(-1, 1);
		const auto any = [&](int rows, int columns) {
			return Eigen::MatrixXd(Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return uniform(random); }));
		};
		const Eigen::MatrixXd Q = any(kUnknowns, kUnknowns).householderQr().householderQ();
		Vector shrink = Vector::LinSpaced(kUnknowns, -0.2, 0.5);
		shrink.tail(3) << 0.9, 0.95, 0.97;
		M = Q * shrink.asDiagonal() * Q.transpose();
		b = any(kUnknowns, 1);
	}
	void sweep()
	{
		x = M * x + b;
		if (limited) x = x.cwiseMin(1);
	}
	/// Runs sweeps until the next one changes x by at most 1e-9. Returns their number.
	int run(btSweepAcceleration* acceleration)
	{
		if (acceleration) acceleration->begin(x.data(), kUnknowns);
		for (int i = 1; i < 2000; ++i)
		{
			const Vector before = x;
			sweep();
			if ((x - before).norm() <= 1e-9) return i;
			if (acceleration) acceleration->advance(x.data());
		}
		return 2000;
	}
};
}  // namespace

TEST(btSweepAcceleration, EndsWhereTheSweepsEndAndSooner)
{
	for (const bool limited : {false, true})
		for (unsigned seed = 1; seed <= 20; ++seed)
		{
			Sweeps alone(seed, limited), accelerated(seed, limited);
			btSweepAcceleration acceleration;
			const int plainly = alone.run(nullptr), so = accelerated.run(&acceleration);
			EXPECT_LT(2 * so, plainly) << "seed " << seed;
			EXPECT_LT((accelerated.x - alone.x).norm(), 1e-6 * alone.x.norm());
			if (limited) continue;
			const Vector exact = (Eigen::MatrixXd::Identity(kUnknowns, kUnknowns) - accelerated.M).partialPivLu().solve(accelerated.b);
			EXPECT_LT((accelerated.x - exact).norm(), 1e-6 * exact.norm());
		}
}

TEST(btSweepAcceleration, StaysWhereNothingChangesAndAllocatesOnce)
{
	btSweepAcceleration acceleration;
	acceleration.reserve(kUnknowns);
	Sweeps still(1, false);
	still.b.setZero();
	const long before = allocationCount();
	acceleration.begin(still.x.data(), kUnknowns);
	for (int i = 0; i < 20; ++i) acceleration.advance(still.x.data());
	EXPECT_EQ(allocationCount(), before);
	EXPECT_EQ(still.x.norm(), 0);
}
