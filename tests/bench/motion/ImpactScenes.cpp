// SPDX-License-Identifier: Zlib
// Bodies that strike each other.
#include "tests/bench/motion/MotionScene.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "tests/bench/bodies/BenchBodies.h"

#include "BulletDynamics/ConstraintSolver/btHingeConstraint.h"

#include <cmath>

using namespace ist;

namespace bench
{
namespace
{
constexpr double kPi = 3.14159265358979323846;

Mat3 turn(const Vec3& rotationVector) { return rotationMatrix(quaternionFromRotationVector(rotationVector)); }

/// Five rings hang side by side, and the first one swings against the others.
class Cradle : public MotionScene
{
public:
	std::optional<Error> prepare(const browser::DemoOptions& options) override
	{
		return add("ring", makeTorusMesh(0.06, 0.02, 48, 24), 400, options);
	}
	void build(browser::DemoWorld& world, bool isGiven) override
	{
		for (int i = 0; i < 5; ++i)
		{
			auto ring = bodySetup("ring", 0.5, 0, isGiven, 1e8, 0.2);
			ring.X_WM.rotation = turn({0, 0, i == 0 ? -kAngle : 0});
			ring.X_WM.translation = Vec3{i * kApart, 0, 0} + ring.X_WM.rotation * Vec3{0, -kArm, 0};
			btRigidBody* body = world.add(solid(0), std::move(ring));
			if (!body) return;
			world.addConstraint(std::make_unique<btHingeConstraint>(*body, btVector3(0, btScalar(kArm), 0), btVector3(0, 0, 1)));
		}
	}

private:
	static constexpr double kArm = 0.4, kAngle = 0.5, kApart = 0.16 + 2e-4;
};

/// Eight dominoes fall, one after the other.
class Dominoes : public MotionScene
{
public:
	std::optional<Error> prepare(const browser::DemoOptions& options) override { return add("domino", makeBoxMesh(kHalf), 300, options); }
	void build(browser::DemoWorld& world, bool isGiven) override
	{
		world.addPlane({0, 1, 0}, 0, 1);
		for (int i = 0; i < 8; ++i)
		{
			auto domino = bodySetup("domino", 0.1, 0.6, isGiven, 1e8, 2);
			domino.X_WM.translation = {i * 0.05, kHalf.y, 0};
			btRigidBody* body = world.add(solid(0), std::move(domino));
			// The first one turns about its lower edge in front.
			if (body && i == 0) setVelocity(*body, 6 * Vec3{kHalf.y, kHalf.x, 0}, {0, 0, -6});
		}
	}

private:
	static constexpr Vec3 kHalf{0.01, 0.05, 0.025};
};

/// A bunny falls on a bunny and tumbles over it.
class Bunnies : public MotionScene
{
public:
	std::optional<Error> prepare(const browser::DemoOptions& options) override
	{
		Mesh mesh = bunnyMesh();
		if (mesh.vertices.empty()) return Error{"there is no bunny: install glmark2-data"};
		const double unit = 0.2 / bounds(mesh).longestSide();
		for (Vec3& p : mesh.vertices) p *= unit;
		return add("bunny", translated(mesh, -massProperties(mesh).centerOfMass), 1000, options);
	}
	void build(browser::DemoWorld& world, bool isGiven) override
	{
		world.addPlane({0, 1, 0}, -0.09, 0.7);
		world.add(solid(0), bodySetup("lower bunny", 0, 0.7, isGiven, 1e8, 2));
		auto bunny = bodySetup("bunny", 1, 0.7, isGiven, 1e8, 2);
		bunny.X_WM.rotation = turn({0.4, 0.9, 0.3});
		bunny.X_WM.translation = {0.01, 0.2, 0};
		if (btRigidBody* body = world.add(solid(0), std::move(bunny))) setVelocity(*body, {}, {1, 0, 2});
	}
};

/// A chain of twenty links hangs by its first one, and swings.
class Chain : public MotionScene
{
public:
	std::optional<Error> prepare(const browser::DemoOptions& options) override
	{
		return add("link", makeTorusMesh(kRing, kTube, 48, 24), 300, options);
	}
	void build(browser::DemoWorld& world, bool isGiven) override
	{
		const Mat3 leans = turn({0, 0, 0.6});
		for (int i = 0; i < 20; ++i)
		{
			auto link = bodySetup("link", i == 0 ? 0 : 0.05, 0.5, isGiven, 1e9, 2);
			link.X_WM.rotation = leans * turn({0, (i % 2) * kPi / 2, 0});
			// The links begin a little apart, so that no energy is stored.
			link.X_WM.translation = leans * Vec3{0, -0.98 * i * 2 * (kRing - kTube), 0};
			world.add(solid(0), std::move(link));
		}
	}

private:
	static constexpr double kRing = 0.05, kTube = 0.012;
};

template <class Scene> std::unique_ptr<MotionScene> make() { return std::make_unique<Scene>(); }
}  // namespace

std::vector<MotionEntry> impactScenes()
{
	return {{"cradle", "One of five rings on hinges swings against the others", nullptr, 1, true, false, true, 15360, make<Cradle>},
		{"dominoes", "Eight dominoes fall, one after the other", nullptr, 1, true, false, true, 15360, make<Dominoes>},
		{"bunnies", "A bunny falls on a bunny and tumbles over it", nullptr, 1, true, true, true, 15360, make<Bunnies>},
		{"chain", "A chain of twenty rings swings by its first one", nullptr, 0.6, true, true, true, 7680, make<Chain>}};
}
}  // namespace bench
