// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Solver/btEnvelopeFactor.h"

#include "tests/unit/CountingAllocator.h"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

namespace
{
using Block = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
using Pairs = std::vector<std::pair<int, int>>;

/// I + sum G G^T with a random G over each coupled pair of places, as the solver makes it, stiff or soft.
struct Matrix
{
	int places;
	Pairs pairs;
	Eigen::MatrixXd dense;

	Matrix(int count, Pairs coupled, unsigned seed, double stiffness)
		: places(count),
		  pairs(std::move(coupled)),
		  dense(Eigen::MatrixXd::Identity(6 * count, 6 * count))
	{
		std::mt19937 random(seed);
		std::uniform_real_distribution<double> uniform(-1, 1);
		for (const auto& [a, b] : pairs)
		{
			Eigen::MatrixXd G = Eigen::MatrixXd::Zero(6 * places, 3);
			for (const int place : {a, b}) G.middleRows<6>(6 * place) = Eigen::MatrixXd::NullaryExpr(6, 3, [&] { return uniform(random); });
			dense += stiffness * G * G.transpose();
		}
	}
	void layOut(btEnvelopeFactor& factor) const
	{
		factor.begin(places);
		for (const auto& [a, b] : pairs) factor.couple(a, b);
		factor.layOut();
	}
	void fill(btEnvelopeFactor& factor) const
	{
		factor.setIdentity();
		const Eigen::MatrixXd rest = dense - Eigen::MatrixXd::Identity(dense.rows(), dense.cols());
		for (int row = 0; row < places; ++row)
			for (int column = 0; column <= row; ++column)
			{
				const Block block = rest.block<6, 6>(6 * row, 6 * column);
				if (!block.isZero(0)) factor.add(row, column, block.data());
			}
	}
};

Pairs chain(int places)
{
	Pairs pairs;
	for (int i = 1; i < places; ++i) pairs.emplace_back(i - 1, i);
	return pairs;
}

Pairs star(int places)
{
	Pairs pairs;
	for (int i = 0; i + 1 < places; ++i) pairs.emplace_back(places - 1, i);
	return pairs;
}

Pairs anyPairs(int places, unsigned seed)
{
	std::mt19937 random(seed);
	Pairs pairs;
	for (int i = 0; i < places; ++i) pairs.emplace_back(int(random() % unsigned(places)), int(random() % unsigned(places)));
	pairs.erase(std::remove_if(pairs.begin(), pairs.end(), [](const auto& p) { return p.first == p.second; }), pairs.end());
	return pairs;
}
}  // namespace

TEST(btEnvelopeFactor, SolvesAndInvertsAsADenseMatrixDoes)
{
	btEnvelopeFactor factor;  // one for all, smaller after larger
	for (unsigned seed = 1; seed <= 60; ++seed)
	{
		const int places = 1 + int(seed * 7 % 12);
		const Pairs pairs = seed % 3 == 0 ? chain(places) : seed % 3 == 1 ? star(places) : anyPairs(places, seed);
		const Matrix matrix(places, pairs, seed, std::pow(10.0, double(seed % 5) - 1));
		matrix.layOut(factor);
		for (int repeat = 0; repeat < 2; ++repeat)
		{
			matrix.fill(factor);
			ASSERT_TRUE(factor.factorise());
			factor.invert();
			const Eigen::VectorXd right = Eigen::VectorXd::LinSpaced(6 * places, -1, 2);
			Eigen::VectorXd x = right;
			factor.solve(x.data());
			EXPECT_LE((matrix.dense * x - right).norm(), 1e-10 * matrix.dense.norm()) << seed;
			const Eigen::MatrixXd inverse = matrix.dense.inverse();
			for (int column = 0; column < places; ++column)
			{
				std::vector<int> members(factor.cliqueBegin(column), factor.cliqueEnd(column));
				members.insert(members.begin(), column);
				ASSERT_TRUE(std::is_sorted(members.begin(), members.end()));
				for (const int row : members)
				{
					const Eigen::Map<const Block> found(factor.inverseBlock(row, column));
					EXPECT_LE((found - inverse.block<6, 6>(6 * row, 6 * column)).norm(), 1e-9) << seed;
				}
			}
		}
	}
}

TEST(btEnvelopeFactor, CliqueHoldsThePlacesThatReachBackToIt)
{
	const Matrix matrix(5, {{0, 2}, {4, 1}, {3, 2}}, 1, 1);
	btEnvelopeFactor factor;
	matrix.layOut(factor);
	const auto clique = [&](int place) { return std::vector<int>(factor.cliqueBegin(place), factor.cliqueEnd(place)); };
	EXPECT_EQ(clique(0), (std::vector<int>{2}));
	EXPECT_EQ(clique(1), (std::vector<int>{2, 4}));
	EXPECT_EQ(clique(2), (std::vector<int>{3, 4}));
	EXPECT_EQ(clique(3), (std::vector<int>{4}));
	EXPECT_EQ(clique(4), std::vector<int>());
	EXPECT_EQ(factor.blocks(), 5 + 6);
	EXPECT_EQ(factor.entries(), 5 * 21 + 6 * 36);
}

TEST(btEnvelopeFactor, WorkOfAChainAndOfAStarIsProportionalToTheirPlaces)
{
	for (const bool isChain : {true, false})
		for (const int places : {4, 16, 64})
		{
			const Matrix matrix(places, isChain ? chain(places) : star(places), 1, 10);
			btEnvelopeFactor factor;
			matrix.layOut(factor);
			matrix.fill(factor);
			ASSERT_TRUE(factor.factorise());
			factor.invert();
			Eigen::VectorXd x = Eigen::VectorXd::Ones(6 * places);
			factor.solve(x.data());
			EXPECT_EQ(factor.products(), uint64_t(11 * places - 7)) << places;
		}
}

TEST(btEnvelopeFactor, RefusesWhatIsNotPositiveDefiniteOrNotFinite)
{
	btEnvelopeFactor factor;
	const Matrix matrix(3, chain(3), 1, 1);
	matrix.layOut(factor);
	for (const double bad : {-1e3, std::nan("")})
	{
		matrix.fill(factor);
		const Block block = Block::Constant(bad);
		factor.add(1, 1, block.data());
		EXPECT_FALSE(factor.factorise());
	}
}

TEST(btEnvelopeFactor, AllocatesNothingWithinWhatIsReserved)
{
	const Matrix first(6, anyPairs(6, 3), 3, 1), second(12, star(12), 1, 1);
	btEnvelopeFactor factor;
	factor.reserve(12);
	Eigen::VectorXd x = Eigen::VectorXd::Ones(72);
	const Block block = Block::Identity();
	const long before = allocationCount();
	for (const Matrix* matrix : {&first, &second})
	{
		matrix->layOut(factor);
		factor.setIdentity();
		for (int i = 0; i < matrix->places; ++i) factor.add(i, i, block.data());
		ASSERT_TRUE(factor.factorise());
		factor.invert();
		factor.solve(x.data());
	}
	EXPECT_EQ(allocationCount(), before);
}
