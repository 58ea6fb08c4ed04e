// SPDX-License-Identifier: Zlib
#include "tests/scenario/soak/SoakRun.h"

#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "tests/unit/CountingAllocator.h"
#include "tests/unit/ResidentMemory.h"

#include "LinearMath/btAlignedAllocator.h"

#include <atomic>
#include <cstdlib>
#include <filesystem>

using namespace scenario;

namespace soak
{
namespace
{
constexpr double kRate = 60;
constexpr double kMostGain = kDouble ? 1e-12 : 1e-6;  // rounding
std::atomic<long> g_liveOfBullet{0};
long g_begun = 0, g_ended = 0;

void* countedAllocate(size_t size)
{
	++g_liveOfBullet;
	return std::malloc(size);
}
void countedFree(void* p)
{
	if (p) --g_liveOfBullet;
	std::free(p);
}

/// Counts contacts that begin and end during its lifetime.
struct Callbacks
{
	Callbacks()
	{
		g_begun = g_ended = 0;
		gContactStartedCallback = [](btPersistentManifold* const&) { ++g_begun; };
		gContactEndedCallback = [](btPersistentManifold* const&) { ++g_ended; };
	}
	~Callbacks()
	{
		gContactStartedCallback = nullptr;
		gContactEndedCallback = nullptr;
	}
};

/// Trees of one world: those in memory, or those read back from the disk.
std::vector<TreePtr> treesFor(const Solids& solids, Random& random, const std::string& folder)
{
	std::vector<TreePtr> trees;
	for (int i = 0; i < Solids::kCount; ++i)
	{
		trees.push_back(solids.of(i).tree);
		if (below(random, 2)) continue;
		const std::string path = folder + "/soak-" + std::to_string(i) + (kDouble ? "-float64.ist" : ".ist");
		EXPECT_TRUE(ist::saveAsset(*trees.back(), path));
		ist::Result<ist::InnerSphereTree> loaded = ist::loadAsset(path);
		EXPECT_TRUE(loaded);
		if (loaded) trees.back() = std::make_shared<const ist::InnerSphereTree>(std::move(loaded).value());
		std::vector<std::byte> bytes = ist::encodeAsset(*solids.of(i).tree);
		bytes[size_t(below(random, int(bytes.size())))] ^= std::byte(1 << below(random, 8));
		EXPECT_FALSE(ist::decodeAsset(bytes.data(), bytes.size()));
	}
	return trees;
}

void expectSound(SoakWorld& world, Tally& tally)
{
	const btCollisionObjectArray& objects = world.bullet().getCollisionObjectArray();
	for (const btISTContact* contact : world.ist().contacts().contacts())
	{
		tally.contacts += contact->patchCount > 0;
		if (contact->stamp == 0) continue;  // not evaluated yet
		for (const btCollisionObject* body : {contact->bodyA, contact->bodyB})
			ASSERT_LT(objects.findLinearSearch(const_cast<btCollisionObject*>(body)), objects.size()) << "contact of a body that is gone";
	}
	for (const Actor& actor : world.actors()) ASSERT_TRUE(actor.poisoned || actor.isFinite()) << "a body that nobody poisoned";
}

/// Brings bodies back into the pit. A body that was teleported into another, or through a wall, may be anywhere by now.
void bringBack(SoakWorld& world, Random& random, Tally& tally)
{
	for (Actor& actor : world.actors())
	{
		if (actor.poisoned || actor.body->getWorldTransform().getOrigin().length2() < 400) continue;
		++tally.broughtBack;
		world.place(actor, world.somewhere(random));
		actor.body->setLinearVelocity(btVector3(0, 0, 0));
		actor.body->forceActivationState(ACTIVE_TAG);  // Bullet puts bodies that have gone too far to sleep permanently
	}
}

void runWild(SoakWorld& world, Random& random, int steps, Tally& tally)
{
	for (int i = 0; i < steps && !testing::Test::HasFatalFailure(); ++i)
	{
		if (below(random, 3) == 0) disturb(world, random, tally);
		if (below(random, 50) == 0) expectRefusals(world, random, tally);
		const bool poisoned = below(random, 60) == 0 && poison(world, random, tally);
		for (int k = 0; k < (poisoned ? 3 : 1); ++k, ++tally.steps)
		{
			if (poisoned) world.spreadPoison();
			world.step(1 / kRate);
			if (poisoned) world.spreadPoison();
			expectSound(world, tally);
		}
		if (poisoned) world.heal(random);
		bringBack(world, random, tally);
	}
}

void runCalm(SoakWorld& world, Random& random, int steps, Tally& tally)
{
	for (int i = 3 + below(random, 6); i > 0; --i)
	{
		const double x = between(random, -2, 2), z = between(random, -2, 2);
		Actor& actor = world.add(random, true);
		world.place(actor, at({x, 1.2 + 1.9 * i, z}, randomVector(random, 2)));
		const double stiffness = below(random, 2) ? std::pow(10, between(random, 3, 6)) : 0;
		EXPECT_FALSE(world.ist().materials().set(actor.body.get(), {stiffness, -1}));
	}
	double allowed = world.energy();
	for (int i = 0; i < steps && !testing::Test::HasFatalFailure(); ++i, ++tally.steps)
	{
		const uint64_t touchedBefore = tally.contacts;
		world.step(1 / kRate);
		expectSound(world, tally);
		const double energy = world.energy();
		tally.worstGain = std::max(tally.worstGain, energy / allowed - 1);
		ASSERT_LT(energy, allowed * (1 + kMostGain)) << "energy from nowhere until step " << i;
		if (tally.contacts == touchedBefore) allowed = energy;  // no energy is stored in contacts
		for (const Actor& actor : world.actors())
			ASSERT_GE(actor.body->getWorldTransform().getOrigin().y(), -world.deepestWith(allowed, actor)) << "fell through in step " << i;
	}
}

void runWorld(const Solids& solids, Random& random, const std::string& folder, Tally& tally)
{
	const WorldKind kind = WorldKind(below(random, int(WorldKind::Count)));
	const int steps = 60 * (5 + below(random, 25));
	{
		SoakWorld world(kind, solids, treesFor(solids, random, folder));
		// Bullet's NNCG solver itself throws piles apart when bodies are put into each other.
		if (kind == WorldKind::Nncg || below(random, 4) == 0) runCalm(world, random, steps, tally);
		else runWild(world, random, steps, tally);
	}
	EXPECT_EQ(g_begun, g_ended) << "contacts that began and contacts that ended";
	g_begun = g_ended = 0;
}
}  // namespace

Tally run(uint64_t seed, double seconds, const std::string& folder, std::optional<uint64_t> only)
{
	btAlignedAllocSetCustom(countedAllocate, countedFree);
	std::filesystem::create_directories(folder);
	const Solids solids;
	cube();  // made before the first count
	Callbacks callbacks;
	Random random(seed);
	Tally tally;
	while (double(tally.steps) < seconds * kRate && !testing::Test::HasFailure())
	{
		const uint64_t state = only ? *only : random();
		SCOPED_TRACE("seed " + std::to_string(seed) + ", world " + std::to_string(tally.worlds) + ", state " + std::to_string(state));
		Random own(state);
		runWorld(solids, own, folder, tally);
		const long live = liveAllocations() + g_liveOfBullet;
		EXPECT_TRUE(tally.worlds == 0 || live == tally.liveAfter) << live - tally.liveAfter << " allocations that were not given back";
		tally.liveAfter = live;
		tally.mostResident = std::max(tally.mostResident, double(residentBytes().value_or(0)) / 1048576);
		++tally.worlds;
	}
	btAlignedAllocSetCustom(nullptr, nullptr);
	return tally;
}
}  // namespace soak
