// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Query/ContactPatches.h"

#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "BulletISTCollision/Core/Query/QueryWorkspaceState.h"
#include "tests/unit/Core/Query/PatchReference.h"
#include "tests/unit/Core/Query/QueryBodies.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

using namespace ist;
using namespace ist::kernels;

namespace
{

/// A list of pairs between balls that are connected in `clusters` groups. The forces lie in `directions` cones, and a few of them are
/// weak.
class RandomPairs
{
public:
	RandomPairs(int count, int clusters, int directions, unsigned seed) : m_random(seed)
	{
		const size_t room = size_t(count) + kListSlack;
		m_index.resize(2 * room);
		m_numbers.resize(PairStream::ColumnCount * room);
		stream = {m_index.data(), m_index.data() + room, m_numbers.data(), room};
		std::uniform_real_distribution<float> any(-1, 1), positive(0.1f, 1);
		std::vector<Vec3> axes(static_cast<size_t>(directions));
		for (Vec3& axis : axes) axis = normalized(Vec3{any(m_random), any(m_random), any(m_random)});
		for (int i = 0; i < count; ++i)
		{
			const uint32_t cluster = pick(clusters);
			stream.a[i] = cluster * kBalls / uint32_t(clusters) + pick(kBalls / clusters);
			stream.b[i] = cluster * kBalls / uint32_t(clusters) + pick(kBalls / clusters);
			const bool weak = pick(12) == 0;
			const Vec3 f = (axes[pick(directions)] + 0.5 * Vec3{any(m_random), any(m_random), any(m_random)}) *
				double(weak ? 1e-3f : positive(m_random));
			for (int k = 0; k < 3; ++k)
			{
				columnOf(stream, PairStream::Force + k)[i] = float(f[k]);
				columnOf(stream, PairStream::Centroid + k)[i] = float(3 * cluster) + any(m_random);
			}
			columnOf(stream, PairStream::Size)[i] = weak ? 0 : float(norm(f));
			columnOf(stream, PairStream::Rank)[i] = float(norm(f));
			columnOf(stream, PairStream::Mass)[i] = 1;
		}
	}
	static constexpr int kBalls = 960;
	PairStream stream;

private:
	uint32_t pick(int below) { return std::uniform_int_distribution<uint32_t>(0, uint32_t(below) - 1)(m_random); }
	std::mt19937 m_random;
	std::vector<uint32_t> m_index;
	std::vector<float> m_numbers;
};

/// Returns null if this machine cannot run the set.
const QueryKernel* kernelOf(InstructionSet set)
{
	QueryCapacity small;
	small.pairs = 1;
	return QueryWorkspace(small, set).implementation().kernel;
}
}  // namespace

TEST(PatchGrouper, AgreesWithTheReferencePairByPair)
{
	for (const InstructionSet set : kInstructionSets)
	{
		const QueryKernel* kernel = kernelOf(set);
		if (!kernel) continue;
		PatchGrouper grouper;
		int manyPatches = 0, manyComponents = 0;
		for (unsigned seed = 1; seed <= 60; ++seed)
		{
			const int count = int(1 + seed * seed * 7 % 1300), clusters = int(1 + seed % 5), directions = int(1 + seed % 4);
			const RandomPairs pairs(count, clusters, directions, seed);
			const int most = seed % 7 == 0 ? 2 : 8;
			grouper.reserve(size_t(count), 2 * RandomPairs::kBalls, most);
			const int found = grouper.group(*kernel, pairs.stream, count, RandomPairs::kBalls, most);
			const PatchReference reference(pairs.stream, count, RandomPairs::kBalls, most);
			ASSERT_EQ(found, reference.count()) << seed << ' ' << toString(set);
			for (int i = 0; i < count; ++i)
				ASSERT_EQ(int(grouper.patch()[i]), reference.patch()[size_t(i)]) << seed << ' ' << i << ' ' << toString(set);
			manyPatches += found > 4;
			manyComponents += reference.components() > 4;
		}
		EXPECT_GT(manyPatches, 10);
		EXPECT_GT(manyComponents, 10);
	}
}

TEST(PatchGrouper, PairsWithoutAnyDirectionAreOnePatch)
{
	const QueryKernel* kernel = kernelOf(InstructionSet::Portable);
	RandomPairs pairs(100, 1, 2, 3);
	for (int i = 0; i < 100; ++i) columnOf(pairs.stream, PairStream::Size)[i] = 0;
	// All pairs share one ball, so they form one component.
	std::fill_n(pairs.stream.a, 100, 5u);
	PatchGrouper grouper;
	grouper.reserve(100, 2 * RandomPairs::kBalls, 8);
	EXPECT_EQ(grouper.group(*kernel, pairs.stream, 100, RandomPairs::kBalls, 8), 1);
	for (int i = 0; i < 100; ++i) EXPECT_EQ(grouper.patch()[i], 0);
	EXPECT_EQ(grouper.group(*kernel, pairs.stream, 0, RandomPairs::kBalls, 8), 0);
}

// The patches sum the same pairs as a query without patches. Any number of patches adds up to its sums, with every instruction set.
TEST(PatchGrouper, PatchesOfAQuerySumToTheQueryWithoutPatches)
{
	const InnerSphereTree A = cloudBody(700, 3), B = cloudBody(650, 4, {0.1, 0.2, -0.1});
	for (const InstructionSet set : kInstructionSets)
	{
		if (!isAvailable(set)) continue;
		std::mt19937 random(11);
		std::uniform_real_distribution<double> u(-1, 1);
		for (int k = 0; k < 8; ++k)
		{
			const Pose X = Pose{
				rotationMatrix(quaternionFromRotationVector({u(random), 2, u(random)})), {0.5 * u(random), 0.5 * u(random), 0.2}};
			QueryOptions plain;
			plain.patches = false;
			QueryWorkspace one({}, set), several({}, set);
			const OverlapResult whole = queryOverlap(A, B, X, one, plain), divided = queryOverlap(A, B, X, several);
			ASSERT_GT(whole.total.pairs, 20);
			EXPECT_EQ(divided.total.pairs, whole.total.pairs);
			EXPECT_NEAR(divided.total.volume, whole.total.volume, 1e-6 * whole.total.volume);
			EXPECT_NEAR(divided.total.depthA, whole.total.depthA, 1e-5 * std::fabs(whole.total.depthA));
			double scale = 0;
			for (int i = 0; i < 6; ++i) scale = std::max(scale, std::fabs(whole.total.stiffnessA(i, i)));
			for (int i = 0; i < 21; ++i) EXPECT_NEAR(divided.total.stiffnessA.m[i], whole.total.stiffnessA.m[i], 1e-4 * scale);
		}
	}
}

TEST(PatchGrouper, ExtendsPatchesToPairsThatSharedABall)
{
	const QueryKernel* kernel = kernelOf(InstructionSet::Portable);
	PatchGrouper grouper;
	constexpr uint32_t kUnknown = RandomPairs::kBalls, kBalls = kUnknown + 1;  // a ball that no pair has
	const std::vector<Sphere> balls(kBalls);
	for (unsigned seed = 1; seed <= 20; ++seed)
	{
		const int count = int(20 + seed * 37);
		RandomPairs random(count, int(1 + seed % 5), int(1 + seed % 4), seed);
		const PairStream& pairs = random.stream;
		grouper.reserve(size_t(count), 2 * kBalls, 8);
		const int patches = grouper.group(*kernel, pairs, count, kBalls, 8);
		const std::vector<float> group(grouper.patch(), grouper.patch() + count);
		// Each grouped pair is followed by one that shares only its ball of A, and one that shares only its ball of B. The last pair
		// shares neither.
		std::vector<uint32_t> a, b;
		for (int i = 0; i < count; ++i)
		{
			a.insert(a.end(), {pairs.a[i], pairs.a[i], kUnknown});
			b.insert(b.end(), {pairs.b[i], kUnknown, pairs.b[i]});
		}
		a.push_back(kUnknown);
		b.push_back(kUnknown);
		std::vector<uint8_t> patchOf(a.size());
		grouper.extend(pairs, count, {a.data(), b.data(), a.size(), kBalls}, balls.data(), patchOf.data());
		const auto someOf = [&](const uint32_t* list, uint32_t ball, uint8_t patch) {
			for (int i = 0; i < count; ++i)
				if (list[i] == ball && group[size_t(i)] == float(patch)) return true;
			return false;
		};
		for (int i = 0; i < count; ++i)
		{
			ASSERT_EQ(float(patchOf[size_t(3 * i)]), group[size_t(i)]);
			ASSERT_TRUE(someOf(pairs.a, pairs.a[i], patchOf[size_t(3 * i) + 1]));
			ASSERT_TRUE(someOf(pairs.b, pairs.b[i], patchOf[size_t(3 * i) + 2]));
		}
		ASSERT_LT(int(patchOf.back()), patches);
	}
}

TEST(PatchGrouper, PairsOfUnknownBallsBelongToTheNearestPatch)
{
	const QueryKernel* kernel = kernelOf(InstructionSet::Portable);
	constexpr uint32_t kBalls = RandomPairs::kBalls + 2;
	std::vector<Sphere> balls(kBalls);
	// There is one unknown ball in the middle of each cluster.
	const uint32_t unknown[] = {kBalls - 2, kBalls - 1};
	for (int cluster = 0; cluster < 2; ++cluster)
		balls[unknown[cluster]] = {3.0f * float(cluster), 3.0f * float(cluster), 3.0f * float(cluster), 1};
	for (unsigned seed = 1; seed <= 20; ++seed)
	{
		constexpr int kCount = 3000;  // this many connect each cluster, except for a few pairs
		RandomPairs random(kCount, 2, 2, seed);
		PatchGrouper grouper;
		grouper.reserve(kCount, 2 * kBalls, 8);
		ASSERT_GT(grouper.group(*kernel, random.stream, kCount, kBalls, 8), 1);
		uint8_t patchOf[2];
		grouper.extend(random.stream, kCount, {unknown, unknown, 2, kBalls}, balls.data(), patchOf);
		for (uint32_t cluster = 0; cluster < 2; ++cluster)
		{
			int here = 0, there = 0;
			for (int i = 0; i < kCount; ++i)
				if (grouper.patch()[i] == GroupNumber(patchOf[cluster]))
					++(random.stream.a[i] / (RandomPairs::kBalls / 2) == cluster ? here : there);
			EXPECT_GT(here, 10 * there) << "mostly a patch of the other cluster";
		}
	}
}

// The contacts form a connected row on a floor that bends by this angle from end to end.
TEST(ContactPatches, OneWhereTheNormalsAgree)
{
	QueryWorkspace workspace;
	for (const double bend : {0.0, 0.3, 0.6, 2.6})
	{
		std::vector<MomentEllipsoid> A, B;
		for (int i = 0; i <= 20; ++i)
		{
			const double angle = bend * (i / 20.0 - 0.5);
			const Vec3 normal{std::sin(angle), 0, std::cos(angle)};
			A.push_back(ballAt({0.05 * i, 0, 0.08}, -0.9 * normal));
			B.push_back(ballAt({0.05 * i, 0, -0.08}, 0.9 * normal));
		}
		const OverlapResult r = queryOverlap(bodyOf(A), bodyOf(B), Pose{}, workspace);
		EXPECT_EQ(r.patchCount == 1, bend < 1) << bend << ": " << r.patchCount << " patches";
	}
}

TEST(ContactPatches, SeparateContactsAndCorners)
{
	// Two feet are far apart on one floor, and a wall belongs to the second foot's component.
	std::vector<MomentEllipsoid> A, B;
	for (int i = 0; i < 5; ++i)
	{
		A.push_back(ballAt({-2 + 0.05 * i, 0, 0.08}, {0, 0, -0.9}));
		B.push_back(ballAt({-2 + 0.05 * i, 0, -0.08}, {0, 0, 0.9}));
		A.push_back(ballAt({2 + 0.05 * i, 0, 0.08}, {0, 0, -0.9}));
		B.push_back(ballAt({2 + 0.05 * i, 0, -0.08}, {0, 0, 0.9}));
	}
	QueryWorkspace workspace;
	OverlapResult r = queryOverlap(bodyOf(A), bodyOf(B), Pose{}, workspace);
	ASSERT_EQ(r.patchCount, 2);
	EXPECT_NEAR(std::fabs(r.patches[0].firstMoment.x / r.patches[0].volume), 2, 0.3);
	for (int i = 0; i < 5; ++i) B.push_back(ballAt({2.32, 0, 0.1 + 0.03 * i}, {-0.9, 0, 0}));
	for (int i = 0; i < 5; ++i) A.push_back(ballAt({2.2, 0, 0.1 + 0.03 * i}, {0.9, 0, 0}));
	r = queryOverlap(bodyOf(A), bodyOf(B), Pose{}, workspace);
	EXPECT_GE(r.patchCount, 3);
	QueryCapacity two;
	two.patches = 2;
	QueryWorkspace limited(two);
	const double volume = r.total.volume;
	r = queryOverlap(bodyOf(A), bodyOf(B), Pose{}, limited);
	EXPECT_EQ(r.patchCount, 2);
	// With another grouping the floats of a lane are added in another order.
	EXPECT_NEAR(r.patches[0].volume + r.patches[1].volume, volume, 1e-6 * volume);
	QueryOptions options;
	options.patches = false;
	EXPECT_EQ(queryOverlap(bodyOf(A), bodyOf(B), Pose{}, workspace, options).patchCount, 1);
}
