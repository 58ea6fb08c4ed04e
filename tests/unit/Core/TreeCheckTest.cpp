// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/TreeCheck.h"

#include "tests/unit/Core/LooseTree.h"
#include "tests/unit/Core/RandomShapes.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace ist
{
namespace
{
BallTree randomTree(size_t count, double scale, double farOff, uint64_t seed)
{
	std::mt19937_64 random(seed);
	std::uniform_real_distribution<double> at(-scale, scale), radius(0.001 * scale, 0.1 * scale);
	std::vector<MomentEllipsoid> balls(count);
	for (MomentEllipsoid& b : balls)
	{
		b.x = float(farOff + at(random));
		b.y = float(at(random));
		b.z = float(at(random));
		b.R = float(radius(random));
		b.density = 0.9f;
		b.nx = 0.5f;
		giveRandomShape(b, random);
	}
	return buildBallTree(balls);
}

TEST(TreeCheck, PassesWhatTheBuilderMakes)
{
	for (size_t count : {1, 15, 16, 17, 400, 20000})
		for (double scale : {1e-3, 1.0, 1e4})
			for (double farOff : {0.0, 1000.0})
				EXPECT_TRUE(surelyValid(randomTree(count, scale, farOff, count))) << count << ' ' << scale << ' ' << farOff;
}

/// Sets one number of the tree, most often in ball and block alike, to something else.
void damage(LooseTree& tree, std::mt19937_64& random)
{
	const auto below = [&](size_t n) { return std::uniform_int_distribution<size_t>(0, n - 1)(random); };
	static constexpr float kOdd[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -1.0f, 0.0f, 1e30f};
	BallNode& node = tree.nodes[below(tree.nodes.size())];
	const size_t index = below(tree.balls.size()), lane = below(BallNode::kWidth);
	MomentEllipsoid& ball = tree.balls[index];
	BallBlock& block = tree.blocks[index / BallBlock::kWidth];
	switch (below(12))
	{
		case 0: node.r[lane] *= 0.9f + 0.0001f * float(below(1000)); break;
		case 1: node.x[lane] += node.r[lane] * 0.0001f * float(below(1000)); break;
		case 2: node.child[lane] = uint32_t(below(tree.nodes.size())); break;
		case 3: node.child[lane] = BallNode::kLeafBit | uint32_t(below(tree.blocks.size() + 1)); break;
		case 4: node.r[lane] = kOdd[below(std::size(kOdd))]; break;
		case 5: block.count = uint32_t(below(18)); break;
		case 6: block.br *= 0.9f + 0.0001f * float(below(1000)); break;
		case 7: ball.yy *= 0.9f + 0.001f * float(below(200)); break;
		case 8:
		{
			float* const shape[] = {&ball.xx, &ball.yy, &ball.zz, &ball.xy, &ball.xz, &ball.yz, &ball.x};
			*shape[below(std::size(shape))] = kOdd[below(std::size(kOdd))];
			block.x[index % BallBlock::kWidth] = ball.x;
			break;
		}
		case 10: block.z[index % BallBlock::kWidth] += 0.01f * float(below(3)); break;
		case 9: ball.depth = kOdd[below(std::size(kOdd))]; break;
		default:
			ball.R *= 1 + 0.01f * float(below(100));
			block.R[index % BallBlock::kWidth] = ball.R;
	}
}

// The slow check is the oracle: what the quick one passes, it must pass. What it passes the quick one may doubt, but rarely does.
TEST(TreeCheck, NeverPassesWhatValidateRefuses)
{
	const BallTree original = randomTree(600, 1, 3, 7);
	std::mt19937_64 random(11);
	int valid = 0, passed = 0, refused = 0;
	for (int round = 0; round < 4000; ++round)
	{
		LooseTree loose(original);
		damage(loose, random);
		const BallTree tree = loose.frozen();
		const bool sound = tree.validate().empty(), sure = surelyValid(tree);
		ASSERT_TRUE(sound || !sure) << "round " << round << ": " << tree.validate();
		valid += sound;
		passed += sure;
		refused += !sound;
	}
	EXPECT_GT(refused, 1000);
	EXPECT_GT(valid, 500);
	EXPECT_GT(passed, valid * 9 / 10);
}
}  // namespace
}  // namespace ist
