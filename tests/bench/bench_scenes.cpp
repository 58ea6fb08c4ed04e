// SPDX-License-Identifier: Zlib
// Measures the cost of one step of a world of N tori that lie on a plane in stacks of up to ten, and prints the state of the world
// beside it. This library is compared with stock Bullet, with GImpact and with a convex decomposition. Then it compares the response of
// one pair with many pairs of leaves with its query. Usage: bench_scenes [--bodies 1,10,100,1000] [--spheres N=1000] [--rate HZ=120]
// [--stiffness PA-PER-M=1e5] [--budget SECONDS=20 a row] [--only PART-OF-NAME]
#include "BulletHapticForce/btBulletHapticForceCommon.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "tests/bench/bodies/PileBodies.h"

#include "BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h"
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <sstream>
#include <string>

using namespace ist;

namespace
{
constexpr double kTube = 0.2, kMass = 1, kGravity = 9.81;
constexpr int kHeight = 10;

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// A solver of Bullet that measures its own time.
template <class Base> struct Timed : Base
{
	using Base::Base;
	double seconds = 0;
	btScalar solveGroup(btCollisionObject** b, int nb, btPersistentManifold** m, int nm, btTypedConstraint** c, int nc,
		const btContactSolverInfo& info, btIDebugDraw* draw, btDispatcher* dispatcher) override
	{
		const double begin = now();
		const btScalar r = Base::solveGroup(b, nb, m, nm, c, nc, info, draw, dispatcher);
		seconds += now() - begin;
		return r;
	}
};
using OurSolver = Timed<btVolumetricSolver<btSequentialImpulseConstraintSolver>>;
using StockSolver = Timed<btSequentialImpulseConstraintSolver>;

struct Pile
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher{&configuration};
	btDbvtBroadphase broadphase;
	btISTRegistration registration;
	std::shared_ptr<btContactMaterialTable> materials = std::make_shared<btContactMaterialTable>();
	std::unique_ptr<OurSolver> ours;
	StockSolver stock;
	std::unique_ptr<btDiscreteDynamicsWorld> world;
	btStaticPlaneShape plane{btVector3(0, 1, 0), 0};
	btRigidBody ground{0, nullptr, &plane};
	std::vector<std::unique_ptr<btRigidBody>> bodies;

	explicit Pile(bool volumetric)
	{
		btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);
		if (volumetric)
		{
			registration = btISTCollisionAlgorithm::registerAlgorithm(&dispatcher, broadphase.getOverlappingPairCache());
			registration.setPairRule(materials);
			registration.store().measureQueryTime(true);
			ours = std::make_unique<OurSolver>(registration.sharedStore());
		}
		btConstraintSolver* solver = volumetric ? static_cast<btConstraintSolver*>(ours.get()) : &stock;
		world = std::make_unique<btDiscreteDynamicsWorld>(&dispatcher, &broadphase, solver, &configuration);
		world->setGravity(btVector3(0, btScalar(-kGravity), 0));
		world->addRigidBody(&ground);
	}
	~Pile()
	{
		for (auto& b : bodies) world->removeRigidBody(b.get());
		world->removeRigidBody(&ground);
	}
	void add(btCollisionShape* shape, const btVector3& inertia, const Vec3& p, double yaw)
	{
		bodies.push_back(std::make_unique<btRigidBody>(btScalar(kMass), nullptr, shape, inertia));
		const btTransform pose(btQuaternion(btVector3(0, 1, 0), btScalar(yaw)), btVector3(btScalar(p.x), btScalar(p.y), btScalar(p.z)));
		bodies.back()->setWorldTransform(pose);
		bodies.back()->setInterpolationWorldTransform(pose);
		bodies.back()->setActivationState(DISABLE_DEACTIVATION);
		world->addRigidBody(bodies.back().get());
	}
	/// Fills the world with stacks of ten. They start at their resting depth, so that all are in contact from the first step on.
	void fill(btCollisionShape* shape, const btVector3& inertia, int count, double sunk)
	{
		std::mt19937_64 random(1);
		std::uniform_real_distribution<double> u(-1, 1);
		const int columns = (count + kHeight - 1) / kHeight, side = int(std::ceil(std::sqrt(columns)));
		for (int i = 0; i < count; ++i)
		{
			const int column = i / kHeight, layer = i % kHeight;
			const double x = 1.6 * (column % side) + 0.02 * u(random), z = 1.6 * (column / side) + 0.02 * u(random);
			add(shape, inertia, {x, ideal(layer) - sunk * (layer + 1), z}, 3 * u(random));
		}
	}
	static double ideal(int layer) { return kTube + 2 * kTube * layer; }
	double solverSeconds() const { return ours ? ours->seconds : stock.seconds; }
	double energy() const
	{
		double sum = 0;
		for (const auto& b : bodies)
		{
			const btVector3 w = b->getWorldTransform().getBasis().transpose() * b->getAngularVelocity(), i = b->getLocalInertia();
			sum += kMass * kGravity * double(b->getWorldTransform().getOrigin().y()) +
				0.5 * kMass * double(b->getLinearVelocity().length2()) +
				0.5 * double(w.x() * w.x() * i.x() + w.y() * w.y() * i.y() + w.z() * w.z() * i.z());
		}
		return sum;
	}
};

struct Options
{
	std::vector<int> bodies{1, 10, 100, 1000};
	int64_t spheres = 1000;
	double rate = 120, budget = 20, stiffness = 1e5;
	std::string only;
};

void measure(const char* name, Pile& pile, const Options& options)
{
	std::vector<double> step, query, solver;
	const double begin = now();
	double most = 0, settled = 0;
	const int wanted = int(2 * options.rate);
	for (int i = 0; i < wanted && (i < 3 || now() - begin < options.budget); ++i)
	{
		if (pile.ours) pile.registration.store().resetQueryTime();
		const double t = now(), s = pile.solverSeconds();
		pile.world->stepSimulation(btScalar(1 / options.rate), 0);
		step.push_back(now() - t);
		solver.push_back(pile.solverSeconds() - s);
		query.push_back(pile.ours ? pile.registration.store().querySeconds() : 0);
		if (i == wanted / 8) settled = pile.energy();
		if (i > wanted / 8) most = std::max(most, pile.energy() - settled);
	}
	// Only the second half counts, because settling costs more or less than resting.
	const auto median = [](std::vector<double> v) {
		v.erase(v.begin(), v.begin() + long(v.size() / 2));
		std::nth_element(v.begin(), v.begin() + long(v.size() / 2), v.end());
		return 1e3 * v[v.size() / 2];
	};
	double sunk = 0, speed = 0;
	int standing = 0, contacts = 0;
	for (size_t i = 0; i < pile.bodies.size(); ++i)
	{
		const double error = double(pile.bodies[i]->getWorldTransform().getOrigin().y()) - Pile::ideal(int(i) % kHeight);
		standing += std::fabs(error) < kTube;
		sunk = std::max(sunk, -error / (int(i) % kHeight + 1));
		speed += double(pile.bodies[i]->getLinearVelocity().length2()) / double(pile.bodies.size());
	}
	for (int i = 0; i < pile.dispatcher.getNumManifolds(); ++i)
		contacts += pile.dispatcher.getManifoldByIndexInternal(i)->getNumContacts() > 0;
	std::printf("%-22s %5zu bodies %6d touching | %9.3f ms a step (query %8.3f, solver %8.3f) | worst sink %6.2f %% a layer, "
				"rms speed %.1e m/s, gains %.1e of its energy, standing %3.0f %%, %zu steps\n",
		name, pile.bodies.size(), contacts, median(step), median(query), median(solver), 100 * sunk / (2 * kTube), std::sqrt(speed),
		settled > 0 ? most / settled : 0, 100.0 * standing / double(pile.bodies.size()), step.size());
	if (pile.ours)
	{
		const btVolumetricStatistics& all = pile.ours->statistics();
		const double steps = double(step.size());
		std::printf("%-22s a step: %.1f patches in %.1f islands, %.2f changes of the pushing set, %.2f times friction not converged, %.2f "
					"held to the ledger\n",
			"", double(all.patches) / steps, double(all.islands) / steps, double(all.activeSetRounds) / steps,
			double(all.frictionNotConverged) / steps, double(all.contactsHeldToEnergyTank) / steps);
	}
	std::fflush(stdout);
}

/// One pair of bodies with many pairs of leaves: the time of the whole solver against that of the query.
void measureResponse(const InnerSphereTree& built, btCollisionShape* shape)
{
	Pile pile(true);
	auto tree = std::make_shared<const InnerSphereTree>(built);
	auto attached = pile.registration.registry().attach(shape, tree);
	if (!attached) return;
	for (const double shift : {0.3, 0.2, 0.1, 0.05})
	{
		pile.add(shape, btVector3(1, 1, 1), {0, 5, 0}, 0);
		pile.add(shape, btVector3(1, 1, 1), {shift, 5 + shift, 0.2 * shift}, 0.7);
		std::vector<double> query, solver;
		long pairs = 0;
		int patches = 0;
		for (int i = 0; i < 60; ++i)
		{
			for (auto& b : pile.bodies) b->setLinearVelocity(btVector3(0, 0, 0)), b->setAngularVelocity(btVector3(0, 0, 0));
			pile.registration.store().resetQueryTime();
			const double s = pile.solverSeconds();
			pile.world->stepSimulation(btScalar(1e-5), 0);
			for (const btISTContact* c : pile.registration.store().contacts())
				if (c->patchCount > 0) pairs = long(c->total.pairs), patches = c->patchCount;
			query.push_back(pile.registration.store().querySeconds());
			solver.push_back(pile.solverSeconds() - s);
		}
		const auto middle = [](std::vector<double>& v) { return std::nth_element(v.begin(), v.begin() + 30, v.end()), 1e6 * v[30]; };
		const double q = middle(query), r = middle(solver);
		std::printf(
			"response to %8ld leaf pairs, %d patches | query %8.1f us, response %7.1f us: %.1f %%\n", pairs, patches, q, r, 100 * r / q);
		for (auto& b : pile.bodies) pile.world->removeRigidBody(b.get());
		pile.bodies.clear();
	}
}

Options parse(int argc, char** argv)
{
	Options o;
	for (int i = 1; i + 1 < argc; i += 2)
	{
		const std::string key = argv[i], value = argv[i + 1];
		if (key == "--spheres") o.spheres = std::atol(value.c_str());
		if (key == "--rate") o.rate = std::atof(value.c_str());
		if (key == "--stiffness") o.stiffness = std::atof(value.c_str());
		if (key == "--budget") o.budget = std::atof(value.c_str());
		if (key == "--only") o.only = value;
		if (key != "--bodies") continue;
		o.bodies.clear();
		std::stringstream list(value);
		for (std::string n; std::getline(list, n, ',');) o.bodies.push_back(std::max(1, std::atoi(n.c_str())));
	}
	return o;
}

InnerSphereTree treeOf(const Mesh& mesh, int64_t spheres)
{
	BuildOptions build;
	build.maxSpheres = spheres;
	Result<InnerSphereTree> tree = buildTree(mesh, build);
	if (!tree) std::printf("%s\n", tree.error().message.c_str()), std::exit(1);
	return std::move(tree).value();
}
}  // namespace

int main(int argc, char** argv)
{
	const Options options = parse(argc, argv);
	const auto wants = [&](const char* name) { return std::string(name).find(options.only) != std::string::npos; };
	Mesh mesh = makeTorusMesh(0.5, kTube, 48, 24);
	for (Vec3& p : mesh.vertices) p = {p.x, -p.z, p.y};  // the body lies flat
	const MassProperties mass = massProperties(mesh);
	const double perVolume = kMass / mass.volume;
	const btVector3 inertia(
		btScalar(perVolume * mass.inertia.m[0][0]), btScalar(perVolume * mass.inertia.m[1][1]), btScalar(perVolume * mass.inertia.m[2][2]));
	btBoxShape bounds(btVector3(btScalar(0.5 + kTube), btScalar(kTube), btScalar(0.5 + kTube)));
	std::printf("tori of %zu triangles, %.0f Hz, float; medians\n", mesh.triangles.size(), options.rate);
	if (wants("ours"))
	{
		auto tree = std::make_shared<const InnerSphereTree>(treeOf(mesh, options.spheres));
		for (const int count : options.bodies)
		{
			Pile pile(true);
			auto attached = pile.registration.registry().attach(&bounds, tree);
			if (!attached) return std::printf("%s\n", attached.error().message.c_str()), 1;
			pile.fill(&bounds, inertia, count, 0.0005);
			for (const auto& body : pile.bodies)
				if (pile.materials->set(body.get(), {options.stiffness, -1})) return 1;
			const std::string name = "ours, " + std::to_string(options.spheres) + " spheres";
			measure(name.c_str(), pile, options);
		}
	}
	const auto peer = [&](const char* name, const bench::PeerShape& shape) {
		if (!shape.shape) return void(std::printf("%s: skipped; apt-get install libbullet-extras-dev\n", name));
		for (const int count : options.bodies)
		{
			Pile pile(false);
			pile.fill(shape.shape.get(), inertia, count, 0.0005);
			measure(name, pile, options);
		}
	};
	if (wants("gimpact")) peer("gimpact", bench::gimpactShape(mesh));
	if (wants("hacd"))
	{
		const bench::PeerShape hulls = bench::hullsByHacd(mesh, 16);
		peer(("hacd, " + std::to_string(hulls.hulls) + " hulls").c_str(), hulls);
	}
	if (wants("response")) measureResponse(treeOf(mesh, 20 * options.spheres), &bounds);
	return 0;
}
