// SPDX-License-Identifier: Zlib
// Bodies that guide, drive or hold each other.
#include "tests/bench/motion/MotionScene.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "demos/browser/base/Threads.h"
#include "demos/browser/drawing/Turned.h"
#include "demos/scenes/Grasp/GraspObjects.h"

#include "BulletDynamics/ConstraintSolver/btHingeConstraint.h"

#include <algorithm>
#include <cmath>

using namespace ist;

namespace bench
{
namespace
{
constexpr double kPi = 3.14159265358979323846, kSteel = 7800;

Mat3 turn(const Vec3& rotationVector) { return rotationMatrix(quaternionFromRotationVector(rotationVector)); }

/// A screw runs down in its nut under its own weight.
class ScrewInNut : public MotionScene
{
public:
	explicit ScrewInNut(double friction) : m_friction(friction) {}
	std::optional<Error> prepare(const browser::DemoOptions& options) override
	{
		if (auto error = add("nut", browser::nut(kThread, 4e-4, 0.07, 0.045), 4000, options)) return error;
		return add("screw", browser::screw(kThread, 0.1, 0.032, 0.014), 4000, options);
	}
	void build(browser::DemoWorld& world, bool isGiven) override
	{
		world.add(solid(0), bodySetup("nut", 0, 1, isGiven, 4e8, 5));
		auto screw = bodySetup("screw", kSteel * solid(1)->tree->volume, m_friction, isGiven, 4e8, 5);
		screw.X_WM.translation = {0, 2 * kThread.lead, 0};
		world.add(solid(1), std::move(screw));
	}
	std::optional<Pose> closedForm(size_t, double time) const override
	{
		if (m_friction > 0) return std::nullopt;
		const double turns = 2 * kPi / kThread.lead, inertia = solid(1)->tree->inertia.m[1][1] / solid(1)->tree->volume;
		const double sunk = 0.5 * kGravity / (1 + inertia * turns * turns) * time * time;
		Pose X;
		X.translation = solid(1)->X_MP.translation + Vec3{0, 2 * kThread.lead - sunk, 0};
		X.rotation = turn({0, -sunk * turns, 0});
		return X;
	}

private:
	static constexpr browser::Thread kThread{};
	double m_friction;
};

/// One gear drives another, which a brake holds back.
class GearPair : public MotionScene
{
public:
	std::optional<Error> prepare(const browser::DemoOptions& options) override
	{
		if (auto error = add("driver", browser::gear(kTeeth[0], kModule, 0.012, 4e-4), 1000, options)) return error;
		return add("driven", browser::gear(kTeeth[1], kModule, 0.012, 4e-4), 1000, options);
	}
	Vec3 gravity() const override { return {}; }
	void build(browser::DemoWorld& world, bool isGiven) override
	{
		const double radii[] = {0.5 * kModule * kTeeth[0], 0.5 * kModule * kTeeth[1]};
		for (const int i : {0, 1})
		{
			auto gear = bodySetup(i ? "driven" : "driver", kSteel * solid(size_t(i))->tree->volume, 0, isGiven, 2e9, 5);
			// A tooth of one gear faces a gap of the other.
			gear.X_WM.rotation = turn({0, i ? kPi * (1 + 1.0 / kTeeth[1]) : 0, 0});
			gear.X_WM.translation = {i ? radii[0] : -radii[1], 0, 0};
			m_bodies[i] = world.add(solid(size_t(i)), std::move(gear));
			if (!m_bodies[i]) return;
			world.addConstraint(std::make_unique<btHingeConstraint>(*m_bodies[i], btVector3(0, 0, 0), btVector3(0, 1, 0)));
		}
	}
	void beforeStep(double) override
	{
		m_bodies[0]->applyTorque(btVector3(0, btScalar(0.6), 0));
		m_bodies[1]->applyTorque(btVector3(0, btScalar(-0.15 * double(m_bodies[1]->getAngularVelocity().y())), 0));
	}

private:
	static constexpr int kTeeth[] = {14, 21};
	static constexpr double kModule = 0.01;
	btRigidBody* m_bodies[2] = {};
};

/// A peg falls, tilted, into a hole with a small clearance.
class PegInHole : public MotionScene
{
public:
	std::optional<Error> prepare(const browser::DemoOptions& options) override
	{
		if (auto error = add("pipe",
				browser::turned(
					{{kHole, 0}, {kOuter, 0}, {kOuter, kHeight}, {1.4 * kHole, kHeight}, {kHole, kHeight - 0.4 * kHole}}, 96, 0.006),
				1500, options))
			return error;
		Mesh peg = makeCylinderMesh(kHole - 0.0012, kPegHalf, 64);
		for (Vec3& p : peg.vertices) p = {p.x, p.z, -p.y};
		return add("peg", peg, 800, options);
	}
	void build(browser::DemoWorld& world, bool isGiven) override
	{
		world.addPlane({0, 1, 0}, 0, 0.3);
		world.add(solid(0), bodySetup("pipe", 0, 0.2, isGiven, 1e9, 5));
		auto peg = bodySetup("peg", kSteel * solid(1)->tree->volume, 0.2, isGiven, 1e9, 5);
		peg.X_WM.translation = {0.003, kHeight + kPegHalf + 0.012, 0};
		peg.X_WM.rotation = turn({0, 0, 0.05});
		world.add(solid(1), std::move(peg));
	}

private:
	static constexpr double kHole = 0.020, kOuter = 0.045, kHeight = 0.06, kPegHalf = 0.05;
};

/// Two fingers close on a mug and lift it. Forces close them; springs lift them.
class Gripper : public MotionScene
{
public:
	std::optional<Error> prepare(const browser::DemoOptions& options) override
	{
		Result<scenes::GraspObject> mug = scenes::makeGraspObject("mug");
		if (!mug) return mug.error();
		m_mug = std::move(mug).value();
		if (auto error = add("mug", m_mug.mesh, 800, options)) return error;
		return add("finger", makeBoxMesh({0.01, 0.015, 0.006}), 200, options);
	}
	void build(browser::DemoWorld& world, bool isGiven) override
	{
		world.addPlane({0, 1, 0}, 0, 0.6);
		world.add(solid(0), bodySetup("mug", m_mug.mass, 0.8, isGiven, 1e9, 5));
		for (const int i : {0, 1})
		{
			auto finger = bodySetup("finger", 0.2, 1, isGiven, 1e9, 5);
			const double side = i ? 1 : -1;
			finger.X_WM.translation = {m_mug.gripX, m_mug.gripHeight, m_mug.gripZ + side * (0.5 * m_mug.width + 0.006 + 0.002)};
			m_fingers[i] = world.add(solid(1), std::move(finger));
			if (!m_fingers[i]) return;
			m_fingers[i]->setAngularFactor(btScalar(0));
			m_fingers[i]->setLinearFactor(btVector3(0, 1, 1));
		}
	}
	void beforeStep(double time) override
	{
		const double lift = m_mug.gripHeight + 0.05 * std::clamp((time - 0.3) / 0.4, 0.0, 1.0), carried = 0.2 + 0.5 * m_mug.mass;
		for (const int i : {0, 1})
		{
			const btRigidBody& f = *m_fingers[i];
			const double y = double(f.getWorldTransform().getOrigin().y()), v = double(f.getLinearVelocity().y());
			const double up = 300 * (lift - y) - 5 * v + kGravity * (time > 0.3 ? carried : 0.2);
			m_fingers[i]->applyCentralForce(btVector3(0, btScalar(up), btScalar((i ? -1 : 1) * 10 * std::min(1.0, time / 0.1))));
		}
	}

private:
	scenes::GraspObject m_mug;
	btRigidBody* m_fingers[2] = {};
};

std::unique_ptr<MotionScene> makeScrew0() { return std::make_unique<ScrewInNut>(0); }
std::unique_ptr<MotionScene> makeScrew1() { return std::make_unique<ScrewInNut>(0.01); }
std::unique_ptr<MotionScene> makeScrew2() { return std::make_unique<ScrewInNut>(0.02); }
std::unique_ptr<MotionScene> makeGears() { return std::make_unique<GearPair>(); }
std::unique_ptr<MotionScene> makePeg() { return std::make_unique<PegInHole>(); }
std::unique_ptr<MotionScene> makeGripper() { return std::make_unique<Gripper>(); }
}  // namespace

std::vector<MotionEntry> assemblyScenes()
{
	constexpr double kScrewing = 8.0 / kCheckpointRate;  // the head meets the nut a little later
	return {{"screw_0", "A screw without friction runs down in its nut", "a = g / (1 + I (2 pi / lead)^2 / m), from rest on its flank",
				kScrewing, false, false, true, 7680, makeScrew0},
		{"screw_001", "The same with a friction of 0.01", nullptr, kScrewing, false, false, true, 7680, makeScrew1},
		{"screw_002", "The same with a friction of 0.02", nullptr, kScrewing, false, false, true, 7680, makeScrew2},
		{"gears", "A gear drives another one against a brake", nullptr, 0.5, true, false, true, 15360, makeGears},
		{"peg", "A peg falls, tilted, into a hole", nullptr, 0.6, true, true, true, 15360, makePeg},
		{"gripper", "Two fingers close on a mug and lift it", nullptr, 0.8, true, false, true, 15360, makeGripper}};
}
}  // namespace bench
