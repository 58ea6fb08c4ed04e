// SPDX-License-Identifier: Zlib
// Measures what the contact cache saves in the demos, and the error that it adds. The reference is the same kernel, queried in full for
// every pair of the broad phase in every step. Also prints for how many patches explicit forces could replace implicit rows. Times are
// the smallest of the repeats; both variants run in turn in one process. Usage: bench_contact_cache [--error E=0.05] [--repeat N=3]
// [--only DEMO] [--cache FOLDER=.]
#include "BulletHapticForce/Law/btContactLaw.h"
#include "BulletISTCollision/Core/Tuning/StableTimeStep.h"
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "demos/browser/base/WorldDemo.h"
#include "demos/browser/catalog/DemoCatalog.h"
#include "demos/browser/catalog/DemoRun.h"
#include "demos/browser/catalog/KeptCheck.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <limits>

using namespace browser;

namespace
{
struct Row
{
	btISTQueryCost cost;
	double querySeconds = std::numeric_limits<double>::infinity(), stepMicroseconds = std::numeric_limits<double>::infinity();
	bool good = true;
};

void add(btISTQueryCost& sum, const btISTQueryCost& cost)
{
	sum.asked += cost.asked;
	sum.cachedApart += cost.cachedApart;
	sum.cachedStill += cost.cachedStill;
	sum.cachedMoved += cost.cachedMoved;
	sum.leafPairs += cost.leafPairs;
	sum.ballTests += cost.ballTests;
	sum.seconds += cost.seconds;
}

/// Treats each patch in each step as a spring along its normal between its two bodies, rotation included.
class PatchSprings
{
public:
	void look(btISTWorld& world, double h)
	{
		btContactPatch patch;
		for (const btISTContact* contact : world.contacts().contacts())
			for (int p = 0; p < contact->patchCount; ++p)
				if (evaluateContactPatch(*contact, p, patch))
					add(patch, mobility(*contact->bodyA, patch) + mobility(*contact->bodyB, patch), h);
	}
	/// h^2 K/m + 2 h c/m of each patch; above 4 explicit forces diverge.
	std::vector<double> numbers;
	double share(long long of) const { return numbers.empty() ? 0 : 100 * double(of) / double(numbers.size()); }
	long long borne = 0;  ///< number of patches at which explicit forces would not diverge
	/// Number of those that leave an impact with a speed that differs by at most kLoss from that of implicit rows.
	long long alike = 0;
	static constexpr double kLoss = 0.05;

private:
	static double mobility(const btCollisionObject& object, const btContactPatch& patch)
	{
		const btRigidBody* body = btRigidBody::upcast(&object);
		return body ? double(body->computeImpulseDenominator(toBullet(patch.point), toBullet(patch.normal))) : 0;
	}
	void add(const btContactPatch& patch, double inverseMass, double h)
	{
		if (!(inverseMass > 0)) return;
		const ist::Twist along{patch.normal, {}};
		const ist::ContactSpring spring{
			dot((patch.stiffness * along).force, patch.normal), 1 / inverseMass, dot((patch.damping * along).force, patch.normal)};
		numbers.push_back((h * h * spring.stiffness + 2 * h * spring.damping) * inverseMass);
		borne += ist::longestExplicitStep(spring) >= h;
		alike += ist::longestExplicitStep(spring) >= h && ist::longestStepForRestitution(spring, kLoss) >= h;
	}
};

/// One run from the beginning. `check` and `springs` may be null; they take time.
void run(WorldDemo& demo, const ContactCacheChoice& contactCache, KeptCheck* check, PatchSprings* springs, Row& row)
{
	demo.setContactCache(contactCache);
	DemoRunOptions options;
	options.afterStep = [&](long long) {
		for (DemoWorld* world : demo.worlds())
		{
			if (check && world->volumetric()) check->look(*world->volumetric());
			if (springs && world->volumetric()) springs->look(*world->volumetric(), demo.stepSize());
		}
		return true;
	};
	const auto outcome = runDemo(demo, "", "", options);
	if (!outcome) std::printf("%s\n", outcome.error().message.c_str()), std::exit(1);
	row.good = row.good && outcome.value().ok();
	row.cost = {};
	for (DemoWorld* world : demo.worlds())
		if (world->volumetric()) add(row.cost, world->volumetric()->contacts().cost());
	if (check) return;
	row.querySeconds = std::min(row.querySeconds, row.cost.seconds);
	row.stepMicroseconds = std::min(row.stepMicroseconds, outcome.value().stepMicroseconds);
}

double median(std::vector<double> values)
{
	if (values.empty()) return 0;
	std::sort(values.begin(), values.end());
	return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
}
}  // namespace

int main(int argc, char** argv)
{
	double error = 0.05;
	int repeat = 3;
	std::string only, cache = ".";
	for (int i = 1; i < argc; i += 2)
	{
		const std::string key = argv[i];
		std::string value = i + 1 < argc ? argv[i + 1] : "";
		if (key == "--error") error = std::atof(value.c_str());
		else if (key == "--repeat") repeat = std::atoi(value.c_str());
		else if (key == "--only") only = value;
		else if (key == "--cache") cache = value;
		else value.clear();
		if (value.empty() || !(error >= 0 && error <= 0.5) || repeat < 1)
			return std::fprintf(
					   stderr, "usage: bench_contact_cache [--error E=0.05, 0 to 0.5] [--repeat N=3] [--only DEMO] [--cache FOLDER=.]\n"),
				   2;
	}
	std::printf("| demo | queries | kept | steps a query | leaf pairs, always / economy | queries [ms], always / economy | factor | step "
				"[us], always / economy | error 95 %% | largest | figures | h^2 K/m + 2 h c/m, median | borne explicitly, alike |\n");
	std::printf("|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
	std::vector<double> factors, counts;
	for (const DemoEntry& entry : demoCatalog())
	{
		const auto demo = entry.make();
		auto* scene = dynamic_cast<WorldDemo*>(demo.get());
		if (!scene || (!only.empty() && only != entry.name)) continue;
		DemoOptions options;
		options.cache = cache;
		if (const auto failed = demo->prepare(options)) return std::printf("%s\n", failed->message.c_str()), 1;
		Row always, contactCache, checked;
		for (int i = 0; i < repeat; ++i)
		{
			run(*scene, {false, 0}, nullptr, nullptr, always);
			run(*scene, {true, error}, nullptr, nullptr, contactCache);
		}
		KeptCheck check;
		PatchSprings springs;
		run(*scene, {true, error}, &check, &springs, checked);
		factors.push_back(always.querySeconds / contactCache.querySeconds);
		counts.push_back(double(always.cost.leafPairs) / double(std::max<int64_t>(contactCache.cost.leafPairs, 1)));
		std::printf("| %s | %llu | %llu | %.3g | %lld / %lld | %.3g / %.3g | %.3g | %.0f / %.0f | %.2f %% | %.2f %% | %s | %.2g | %.0f %%, "
					"%.1f %% |\n",
			entry.name, static_cast<unsigned long long>(contactCache.cost.asked),
			static_cast<unsigned long long>(contactCache.cost.cached()), contactCache.cost.factor(),
			static_cast<long long>(always.cost.leafPairs), static_cast<long long>(contactCache.cost.leafPairs), 1e3 * always.querySeconds,
			1e3 * contactCache.querySeconds, factors.back(), always.stepMicroseconds, contactCache.stepMicroseconds,
			100 * check.share(0.95), 100 * check.largest(), always.good && contactCache.good ? "good" : "NOT as expected",
			median(springs.numbers), springs.share(springs.borne), springs.share(springs.alike));
		std::fflush(stdout);
	}
	std::printf("\nmedian factor of the time of queries %.3g, of the leaf pairs %.3g; at most %.3g of the force granted to what is kept\n",
		median(factors), median(counts), error);
	return 0;
}
