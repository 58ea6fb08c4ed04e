// SPDX-License-Identifier: Zlib
#include "tests/scenario/VolumetricScene.h"

#include <cstdio>
#include <functional>
#include <numbers>

using namespace scenario;
using ist::Mesh;
using ist::Vec3;

// Bodies whose surfaces lie along each other all around. The oracles are the closed forms of machine elements.
namespace
{
constexpr double kPi = std::numbers::pi, kGravity = 9.81;

/// A round body along y between -length / 2 and length / 2, whose radii are functions of the angle and y. Without `inner` it is full.
Mesh roundBody(int around, int along, double length, const std::function<double(double angle, double y)>& outer,
	const std::function<double(double angle, double y)>& inner = {})
{
	Mesh mesh;
	const uint32_t n = uint32_t(around), rings = uint32_t(along) + 1;
	const auto addRings = [&](const std::function<double(double, double)>& radius) {
		for (uint32_t j = 0; j < rings; ++j)
			for (uint32_t i = 0; i < n; ++i)
			{
				const double angle = 2 * kPi * i / n, y = length * (double(j) / along - 0.5), r = radius(angle, y);
				mesh.vertices.push_back({r * std::sin(angle), y, r * std::cos(angle)});
			}
	};
	const auto at = [&](uint32_t surface, uint32_t i, uint32_t j) { return (surface * rings + j) * n + i % n; };
	const auto addQuad = [&](uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
		mesh.triangles.push_back({a, b, c});
		mesh.triangles.push_back({a, c, d});
	};
	addRings(outer);
	if (inner) addRings(inner);
	for (uint32_t j = 0; j + 1 < rings; ++j)
		for (uint32_t i = 0; i < n; ++i)
		{
			addQuad(at(0, i, j), at(0, i + 1, j), at(0, i + 1, j + 1), at(0, i, j + 1));
			if (inner) addQuad(at(1, i, j), at(1, i, j + 1), at(1, i + 1, j + 1), at(1, i + 1, j));
		}
	if (inner)
		for (uint32_t i = 0; i < n; ++i)
		{
			addQuad(at(0, i, 0), at(1, i, 0), at(1, i + 1, 0), at(0, i + 1, 0));
			addQuad(at(0, i, rings - 1), at(0, i + 1, rings - 1), at(1, i + 1, rings - 1), at(1, i, rings - 1));
		}
	else
	{
		const uint32_t bottom = uint32_t(mesh.vertices.size());
		mesh.vertices.push_back({0, -length / 2, 0});
		mesh.vertices.push_back({0, length / 2, 0});
		for (uint32_t i = 0; i < n; ++i)
		{
			mesh.triangles.push_back({bottom, at(0, i + 1, 0), at(0, i, 0)});
			mesh.triangles.push_back({bottom + 1, at(0, i, rings - 1), at(0, i + 1, rings - 1)});
		}
	}
	return mesh;
}

/// ISO metric thread M20 x 2.5: flanks at 30 degrees to the plane across the axis, crest an eighth of the pitch wide, root a quarter.
struct Thread
{
	static constexpr double kPitch = 2.5e-3, kMajor = 0.01, kMinor = kMajor - 0.625 * 0.8660254 * kPitch, kClearance = 0.15e-3;

	static double radius(double angle, double y)
	{
		const double phase = y / kPitch - angle / (2 * kPi), fromCrest = std::fabs(phase - std::round(phase));
		return kMinor + (kMajor - kMinor) * std::clamp((0.375 - fromCrest) / (0.375 - 0.0625), 0.0, 1.0);
	}
	static constexpr int kAround = 96, kPerTurn = 32;
	static Mesh bolt() { return roundBody(kAround, 12 * kPerTurn, 12 * kPitch, radius); }
	static Mesh nut()
	{
		return roundBody(
			kAround, 6 * kPerTurn, 6 * kPitch, [](double, double) { return 0.015; },
			[](double angle, double y) { return radius(angle, y) + kClearance; });
	}
};

/// A nut on a fixed bolt that stands upright.
struct NutOnBolt : Scene
{
	static constexpr double kMass = 0.06, kInertia = 1.1e-5;
	btRigidBody* nut;

	NutOnBolt(const Solid& bolt, const Solid& nutSolid, double friction, double k)
	{
		world.setGravity(btVector3(0, btScalar(-kGravity), 0));
		btRigidBody* fixed = add(volumetricShape(bolt), 0, 0, at({}));
		nut = add(volumetricShape(nutSolid), kMass, kInertia, at({0, 2 * Thread::kPitch, 0}));
		fixed->setFriction(1);
		nut->setFriction(btScalar(friction));
		if (k > 0) setStiffness(nut, k);
	}

	/// Rigid bodies on a helix: N is the sum of the normal forces on the flank, at the mean radius r.
	///   m (g - s a) = N (c + mu sin(lambda)), I a = r N (c tan(lambda) - mu cos(lambda)), s = pitch / 2 pi, c: vertical part of the normal
	static double acceleration(double friction)
	{
		const double r = 0.5 * (Thread::kMajor + Thread::kMinor + Thread::kClearance), s = Thread::kPitch / (2 * kPi), rise = s / r;
		const double c = 1 / std::sqrt(1 + 1 / 3.0 + rise * rise), lambda = std::atan(rise);
		const double up = c + friction * std::sin(lambda), moment = r * (c * rise - friction * std::cos(lambda));
		return moment > 0 ? kMass * kGravity * moment / (kInertia * up + kMass * s * moment) : 0;
	}
	/// Measured over the later part of a second, when the nut lies on the flank [rad/s^2].
	double measured(double rate)
	{
		run(0.4, rate);
		const double before = double(nut->getAngularVelocity().y());
		run(0.6, rate);
		return std::fabs(double(nut->getAngularVelocity().y()) - before) / 0.6;
	}
};
}  // namespace

// The flanks are 0.075 mm apart, a fifth to a third of the gaps between the spheres. Below its lead angle the nut turns. The closed form is
// that of a smooth thread.
TEST(Fit, ANutRunsDownItsBoltAsItsFrictionSays)
{
	const double free = NutOnBolt::acceleration(0);
	for (const int spheres : {1000, 3000})
	{
		const Solid bolt(Thread::bolt(), spheres), nut(Thread::nut(), spheres);
		for (const auto& [rate, k] : {std::pair{240.0, 1e8}, {60.0, 0.0}, {240.0, 0.0}})
			for (const double friction : {0.0, 0.02, 0.045})
			{
				SCOPED_TRACE(testing::Message() << spheres << " spheres, " << rate << " Hz, k " << k << ", friction " << friction);
				NutOnBolt scene(bolt, nut, friction, k);
				const double is = scene.measured(rate), exact = NutOnBolt::acceleration(friction);
				std::printf("  %d spheres, %g Hz, k %g, friction %g: %.2f of %.2f rad/s^2\n", spheres, rate, k, friction, is, exact);
				EXPECT_NEAR(is, exact, (friction > 0 ? 0.04 : 0.02) * free);
			}
	}
}

// The pin is wider than the bore. Friction acts all around, where the normals of a patch differ. A torque makes the pin slip 7 % too early:
// the friction of a patch acts at its centroid, which lies nearer to the axis than its surface.
TEST(Fit, APinInANarrowBoreSlidesAtTheForceOfItsFriction)
{
	constexpr double kRadius = 0.01, kLength = 0.02, kInterference = 20e-6, kStiffness = 1e9, kFriction = 0.3;
	const auto of = [](double radius) { return [=](double, double) { return radius; }; };
	const Solid pin(roundBody(192, 4, 2 * kLength, of(kRadius)), 1000);
	const Solid block(roundBody(192, 4, kLength, of(0.03), of(kRadius - kInterference)), 1000);
	const double borne = kFriction * kStiffness * kInterference * 2 * kPi * (kRadius - kInterference / 2) * kLength;
	// Way of the pin's surface in a tenth of a second.
	const auto slid = [&](double force, double torque) {
		Scene scene;
		scene.world.setGravity(btVector3(0, 0, 0));
		btRigidBody* fixed = scene.add(scene.volumetricShape(block), 0, 0, at({}));
		btRigidBody* body = scene.add(scene.volumetricShape(pin), 0.1, 1e-5, at({}));
		fixed->setFriction(1);
		body->setFriction(btScalar(kFriction));
		scene.setStiffness(body, kStiffness);
		for (int i = 0; i < 100; ++i)
		{
			body->applyCentralForce(btVector3(0, btScalar(force), 0));
			body->applyTorque(btVector3(0, btScalar(torque), 0));
			scene.step(1e-3);
		}
		return height(body) + 0.1 * kRadius * double(body->getAngularVelocity().y());
	};
	EXPECT_LT(slid(0.95 * borne, 0), 1e-6);
	EXPECT_GT(slid(1.05 * borne, 0), 1e-2);
	EXPECT_LT(slid(0, 0.9 * borne * kRadius), 1e-6);
	EXPECT_GT(slid(0, 1.02 * borne * kRadius), 1e-2);
}
