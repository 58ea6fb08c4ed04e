// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Law/btPaperLaw.h"
#include "tests/scenario/extremes/ExtremeTest.h"
#include "tests/unit/CountingAllocator.h"

#include <random>

using namespace extremes;

namespace
{
constexpr double kPi = 3.14159265358979323846;

/// Lens of two balls at the distance d, with R + r > d > |R - r|: two spherical caps.
struct LensForm
{
	double volume = 0, area = 0, fromA = 0;  // fromA: distance of the centroid from A's centre, towards B

	LensForm(double R, double r, double d)
	{
		if (d >= R + r) return;
		if (d <= std::fabs(R - r))
		{
			const double small = std::min(R, r);
			volume = 4.0 / 3 * kPi * small * small * small;
			fromA = R < r ? 0 : d;
			return;
		}
		const double depth = R + r - d, x = (d * d + R * R - r * r) / (2 * d);
		volume = kPi * depth * depth * (d * d + 2 * d * (R + r) - 3 * (R - r) * (R - r)) / (12 * d);
		area = kPi * (R * R - x * x);
		// The first moment of the cap of A beyond x is pi (R^2 - x^2)^2 / 4 about A's centre. The same holds for B's cap about B's
		// centre.
		const double y = d - x, capB = kPi / 3 * (r - y) * (r - y) * (2 * r + y);
		fromA = (kPi / 4 * (R * R - x * x) * (R * R - x * x) - kPi / 4 * (r * r - y * y) * (r * r - y * y) + d * capB) / volume;
	}
};

/// Equations (1) and (2) over all pairs of spheres, in double.
btPaperContact reference(const ExtremeSolid& solid, const btRigidBody& a, const btRigidBody& b, const btPaperMaterial& material)
{
	const ist::Pose X_A = toPose(a.getWorldTransform()), X_B = toPose(b.getWorldTransform());
	btPaperContact out;
	for (const bool summing : {true, false})
		for (const ist::Sphere& i : solid.tree->spheres)
			for (const ist::Sphere& j : solid.tree->spheres)
			{
				const ist::Vec3 ci = X_A * (solid.tree->origin + i.center()), cj = X_B * (solid.tree->origin + j.center());
				const double d = norm(ci - cj);
				if (d >= i.r + j.r) continue;
				const LensForm lens(i.r, j.r, d);
				if (summing)
				{
					out.volume += lens.volume;
					++out.pairs;
					continue;
				}
				const ist::Vec3 n = (ci - cj) / d, C = ci - lens.fromA * n;
				const auto at = [&](const btRigidBody& body) {
					return toVec3(body.getLinearVelocity()) +
						cross(toVec3(body.getAngularVelocity()), C - toVec3(body.getWorldTransform().getOrigin()));
				};
				const double vel = dot(at(a) - at(b), n);
				const double f = std::max(lens.volume * (material.epsilonC - vel * material.epsilonD / out.volume), 0.0);
				const ist::Vec3 F = f * n;
				out.onA = out.onA + ist::Wrench{F, cross(C - toVec3(a.getWorldTransform().getOrigin()), F)};
				out.onB = out.onB - ist::Wrench{F, cross(C - toVec3(b.getWorldTransform().getOrigin()), F)};
			}
	return out;
}

/// A ball of one inner sphere on another that is fixed. It moves only along the line of their centres, and the force `weight` pulls at
/// it.
struct OneSphere
{
	static const ExtremeSolid& body()
	{
		static const ExtremeSolid solid = solidOf(ist::makeBoxMesh({1, 1, 1}), 1);
		return solid;
	}
	const ExtremeSolid& ball = body();
	double radius = double(ball.tree->spheres[0].r);
	const double mass = 2, weight = 50, depth = 0.1;
	btPaperMaterial material;

	explicit OneSphere(double damping)
	{
		material.epsilonC = weight / LensForm(radius, radius, 2 * radius - depth).volume;
		material.epsilonD = damping;
	}
	/// True when a small disturbance of the rest has grown a hundredfold. `predicted` is the law's own number at rest.
	bool diverges(double h, double& predicted) const
	{
		ExtremeWorld world(Response::Volumetric, weight / mass);
		btRigidBody* below = world.add(ball, 0, 0, transformOf({}));
		const double rest = 2 * radius - depth;
		btRigidBody* body = world.add(ball, mass, 1, transformOf({0, rest + 1e-4 * depth, 0}));
		body->setLinearFactor(btVector3(0, 1, 0));
		body->setAngularFactor(btScalar(0));
		btPaperLaw law(16);
		EXPECT_FALSE(law.add(body, ball.tree, below, ball.tree, material));
		double worst = 0;
		for (int i = 0; i < 300; ++i)
		{
			law.apply(h);
			if (i == 0)
			{
				predicted = law.contact(0).stability;
				EXPECT_EQ(law.unstable(), predicted > 4 ? 1u : 0u);
			}
			world.step(h);
			worst = std::max(worst, std::fabs(double(body->getWorldTransform().getOrigin().y()) - rest));
			if (worst > 1e-2 * depth) return true;
		}
		return false;
	}
};
}  // namespace

TEST(PaperLaw, IsEquationsOneAndTwo)
{
	const ExtremeSolid solid = solidOf(ist::makeTorusMesh(0.4, 0.2, 48, 24), 200);
	std::mt19937_64 random(7);
	const auto vector = [&](double size) {
		std::uniform_real_distribution<double> u(-size, size);
		const double x = u(random), y = u(random);
		return ist::Vec3{x, y, u(random)};
	};
	int touching = 0, held = 0;
	for (int seed = 0; seed < 40; ++seed)
	{
		ExtremeWorld world(Response::Volumetric, 0);
		const ist::Vec3 place = vector(seed == 0 && kDouble ? 1000 : 5);
		btRigidBody* a = world.add(solid, 2, 0.3, transformOf(place + vector(0.4), vector(2)));
		btRigidBody* b = world.add(solid, 3, 0.4, transformOf(place, vector(2)));
		for (btRigidBody* body : {a, b})
		{
			body->setLinearVelocity(toBullet(vector(2)));
			body->setAngularVelocity(toBullet(vector(2)));
		}
		const btPaperMaterial material{1e4, 20};
		const btPaperContact exact = reference(solid, *a, *b, material);
		btPaperLaw law(20000);
		ASSERT_FALSE(law.add(a, solid.tree, b, solid.tree, material));
		law.apply(1e-3);
		const btPaperContact& out = law.contact(0);
		held += out.held;
		if (exact.pairs < 5) continue;
		++touching;
		const double size = norm(exact.onA.force) + material.epsilonC * exact.volume, tolerance = kDouble ? 1e-4 : 1e-3;
		EXPECT_NEAR(out.volume, exact.volume, tolerance * exact.volume) << seed;
		EXPECT_LT(norm(out.onA.force - exact.onA.force), tolerance * size) << seed;
		EXPECT_LT(norm(out.onA.torque - exact.onA.torque), tolerance * size) << seed;
		EXPECT_LT(norm(out.onB.torque - exact.onB.torque), tolerance * size) << seed;
		EXPECT_EQ(norm(out.onA.force + out.onB.force), 0) << seed;
		// Newton's third law holds for the forces that Bullet received.
		EXPECT_EQ(double((a->getTotalForce() + b->getTotalForce()).length()), 0) << seed;
	}
	EXPECT_GT(touching, 20);
	EXPECT_GT(held, 0);
}

// The limit is found by bisection on the step; the prediction is the law's own number at rest.
TEST(PaperLaw, DivergesWhereItSays)
{
	for (const double damping : {0.0, 20.0, 60.0})
	{
		const OneSphere scene(damping);
		double low = 0.02, high = 0.2, predicted = 0;
		ASSERT_FALSE(scene.diverges(low, predicted));
		ASSERT_TRUE(scene.diverges(high, predicted));
		for (int i = 0; i < 14; ++i)
		{
			const double h = std::sqrt(low * high);
			(scene.diverges(h, predicted) ? high : low) = h;
		}
		scene.diverges(low, predicted);
		// k and c also have a closed form.
		const double k = scene.material.epsilonC * LensForm(scene.radius, scene.radius, 2 * scene.radius - scene.depth).area;
		const double exact = low * low * k / scene.mass + 2 * low * damping / scene.mass;
		std::printf("  damping %g N s/m: diverges at a step of %.5f s, where the law says %.4f and the closed form %.4f\n", damping, low,
			predicted, exact);
		EXPECT_NEAR(predicted, 4, 0.08) << damping;
		EXPECT_NEAR(exact, 4, 0.08) << damping;
	}
}

TEST(PaperLaw, RefusesWhatItCannotUseAndCountsWhatItLeavesOut)
{
	ExtremeWorld world(Response::Volumetric, 0);
	const auto tree = unitCube().tree;
	btRigidBody *a = world.add(unitCube(), 1, 1, transformOf({})), *b = world.add(unitCube(), 1, 1, transformOf({0.5, 0.1, 0}));
	btPaperLaw law(10);
	EXPECT_TRUE(law.add(a, tree, a, tree, {1, 0}));
	EXPECT_TRUE(law.add(a, tree, nullptr, tree, {1, 0}));
	EXPECT_TRUE(law.add(a, nullptr, b, tree, {1, 0}));
	EXPECT_TRUE(law.add(a, tree, b, tree, {-1, 0}));
	EXPECT_TRUE(law.add(a, tree, b, tree, {1, std::numeric_limits<double>::infinity()}));
	EXPECT_FALSE(law.add(a, tree, b, tree, {1e4, 0}));
	EXPECT_TRUE(law.add(b, tree, a, tree, {1e4, 0}));
	law.apply(1e-3);
	EXPECT_EQ(law.refused(), 1u);
	EXPECT_EQ(a->getTotalForce().length(), btScalar(0));
	law.remove(b);
	EXPECT_EQ(law.pairCount(), 0);
	EXPECT_TRUE(a->checkCollideWith(b));
}

TEST(PaperLaw, AllocatesNothingWhenApplied)
{
	ExtremeWorld world(Response::Volumetric, 0);
	btRigidBody *a = world.add(unitCube(), 1, 1, transformOf({})), *b = world.add(unitCube(), 1, 1, transformOf({0.5, 0.1, 0}));
	btPaperLaw law;
	ASSERT_FALSE(law.add(a, unitCube().tree, b, unitCube().tree, {1e4, 1}));
	law.apply(1e-3);
	const long before = allocationCount();
	for (int i = 0; i < 10; ++i) law.apply(1e-3);
	EXPECT_EQ(allocationCount(), before);
	EXPECT_GT(law.contact(0).pairs, 10);
}
