// SPDX-License-Identifier: Zlib
// Measures the cost of one step of a chain of rings, and prints what the chain looks like beside it. The chain hangs by its first link,
// or falls onto a plane and piles up: one island of bodies with many patches. Times are processor time of the thread. Usage:
// bench_chain [--falls 1] [--links N=40] [--spheres N=1000] [--rate HZ=120] [--steps N=240] [--friction F=0.5] [--stiffness
// PA-PER-M=1e7]
#include "BulletHapticForce/btBulletHapticForceCommon.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <memory>
#include <vector>

using namespace ist;

namespace
{
constexpr double kRing = 0.5, kTube = 0.12, kMass = 1, kGravity = 9.81;
constexpr double kPitch = 2 * (kRing - kTube);  // distance of the centres when two links touch
constexpr double kSlack = 0.97;                 // the chain begins with links apart, so no energy is stored

struct Options
{
	int links = 40, steps = 240;
	int64_t spheres = 1000;
	double rate = 120, friction = 0.5, stiffness = 1e7;
	bool falls = false;
};

double threadSeconds()
{
	timespec t;
	clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
	return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

double median(std::vector<double> v)
{
	std::nth_element(v.begin(), v.begin() + long(v.size() / 2), v.end());
	return v[v.size() / 2];
}

struct Chain
{
	btISTWorld world;
	btBoxShape bounds{btVector3(btScalar(kRing + kTube), btScalar(kRing + kTube), btScalar(kTube))};
	btStaticPlaneShape plane{btVector3(0, 1, 0), 0};
	btISTAttachment attachment;
	std::vector<std::unique_ptr<btRigidBody>> bodies;
	double inertia[3];

	Chain(std::shared_ptr<const InnerSphereTree> tree, const MassProperties& mass, const Options& options)
	{
		attachment = world.attach(&bounds, tree).value();
		for (int i = 0; i < 3; ++i) inertia[i] = kMass / mass.volume * mass.inertia.m[i][i];
		add(&plane, 0, btTransform::getIdentity());
		// Each link is turned by 90 degrees relative to the one above. The chain hangs by its first link, or falls onto the plane,
		// where it piles up.
		const double bottom = kRing + kTube + (options.falls ? 0 : 1);
		for (int i = 0; i < options.links; ++i)
		{
			const btVector3 place(0, btScalar(bottom + kSlack * kPitch * (options.links - 1 - i)), 0);
			const btQuaternion turn(btVector3(0, 1, 0), btScalar((i % 2) * 1.5707963));
			add(&bounds, i == 0 && !options.falls ? 0 : kMass, btTransform(turn, place));
			bodies.back()->setFriction(btScalar(options.friction));
			if (world.materials().set(bodies.back().get(), {options.stiffness, -1})) std::exit(1);
		}
	}
	~Chain()
	{
		for (auto& body : bodies) world.bullet().removeRigidBody(body.get());
	}
	void add(btCollisionShape* shape, double mass, const btTransform& pose)
	{
		const btVector3 i = mass > 0 ? btVector3(btScalar(inertia[0]), btScalar(inertia[1]), btScalar(inertia[2])) : btVector3(0, 0, 0);
		bodies.push_back(std::make_unique<btRigidBody>(btScalar(mass), nullptr, shape, i));
		bodies.back()->setWorldTransform(pose);
		bodies.back()->setInterpolationWorldTransform(pose);
		bodies.back()->setActivationState(DISABLE_DEACTIVATION);
		world.bullet().addRigidBody(bodies.back().get());
	}
	double energy() const
	{
		double sum = 0;
		for (const auto& b : bodies)
		{
			if (b->isStaticObject()) continue;
			const btVector3 w = b->getWorldTransform().getBasis().transpose() * b->getAngularVelocity();
			sum += kMass * (kGravity * double(b->getWorldTransform().getOrigin().y()) + 0.5 * double(b->getLinearVelocity().length2()));
			for (int k = 0; k < 3; ++k) sum += 0.5 * inertia[k] * double(w[k]) * double(w[k]);
		}
		return sum;
	}
	/// Largest distance of two neighbours over the pitch, minus 1: how far links have sunk into each other.
	double stretch() const
	{
		double worst = 0;
		for (size_t i = 2; i < bodies.size(); ++i)
		{
			const btVector3 d = bodies[i]->getWorldTransform().getOrigin() - bodies[i - 1]->getWorldTransform().getOrigin();
			worst = std::max(worst, double(d.length()) / kPitch - 1);
		}
		return worst;
	}
	double speed() const
	{
		double sum = 0;
		for (const auto& b : bodies) sum += double(b->getLinearVelocity().length2());
		return std::sqrt(sum / double(bodies.size()));
	}
};

Options parse(int argc, char** argv)
{
	Options o;
	for (int i = 1; i + 1 < argc; i += 2)
	{
		const double value = std::atof(argv[i + 1]);
		if (!std::strcmp(argv[i], "--falls")) o.falls = value != 0;
		else if (!std::strcmp(argv[i], "--links")) o.links = int(value);
		else if (!std::strcmp(argv[i], "--spheres")) o.spheres = int64_t(value);
		else if (!std::strcmp(argv[i], "--rate")) o.rate = value;
		else if (!std::strcmp(argv[i], "--steps")) o.steps = int(value);
		else if (!std::strcmp(argv[i], "--stiffness")) o.stiffness = value;
		else if (!std::strcmp(argv[i], "--friction")) o.friction = value;
		else std::printf("unknown option %s\n", argv[i]), std::exit(1);
	}
	return o;
}
}  // namespace

int main(int argc, char** argv)
{
	const Options options = parse(argc, argv);
	const Mesh mesh = makeTorusMesh(kRing, kTube, 48, 24);
	BuildOptions build;
	build.maxSpheres = options.spheres;
	Result<InnerSphereTree> tree = buildTree(mesh, build);
	if (!tree) return std::printf("%s\n", tree.error().message.c_str()), 1;
	Chain chain(std::make_shared<const InnerSphereTree>(std::move(tree).value()), massProperties(mesh), options);
	chain.world.contacts().measureQueryTime(true);
	std::vector<double> step, query;
	const double start = chain.energy();
	double most = 0;
	for (int i = 0; i < options.steps; ++i)
	{
		chain.world.contacts().resetQueryTime();
		const double begin = threadSeconds();
		if (chain.world.step(1 / options.rate)) return 1;
		step.push_back(1e3 * (threadSeconds() - begin));
		query.push_back(1e3 * chain.world.contacts().querySeconds());
		most = std::max(most, chain.energy() - start);
	}
	const btVolumetricStatistics& all = chain.world.statistics();
	const double steps = double(options.steps);
	std::printf("%d links of %lld spheres, %.0f Hz: a step %.2f ms in the median, %.2f at most (query %.2f) | stretch %.3f %%, rms speed "
				"%.2e m/s, energy %.1f -> %.1f J, at most %+.1e above its start\n",
		options.links, static_cast<long long>(options.spheres), options.rate, median(step), *std::max_element(step.begin(), step.end()),
		median(query), 100 * chain.stretch(), chain.speed(), start, chain.energy(), most);
	std::printf("a step: %.1f patches, %.2f islands solved at once, %.2f too large, %.2f changes of the pushing set, %.2f times friction "
				"not converged, %.2f held to the ledger\n",
		double(all.patches) / steps, double(all.islands) / steps, double(all.islandsTooLarge) / steps, double(all.activeSetRounds) / steps,
		double(all.frictionNotConverged) / steps, double(all.contactsHeldToEnergyTank) / steps);
	return 0;
}
