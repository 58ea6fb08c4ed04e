// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Solver/btVolumetricRows.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

using ist::Vec3;

namespace
{
using Vector = std::vector<double>;
using Matrix = std::vector<Vector>;

Matrix zeros(size_t n) { return Matrix(n, Vector(n, 0)); }

Matrix product(const Matrix& a, const Matrix& b)
{
	Matrix c = zeros(a.size());
	for (size_t i = 0; i < a.size(); ++i)
		for (size_t j = 0; j < a.size(); ++j)
			for (size_t k = 0; k < a.size(); ++k) c[i][j] += a[i][k] * b[k][j];
	return c;
}

Vector product(const Matrix& a, const Vector& x)
{
	Vector y(x.size(), 0);
	for (size_t i = 0; i < x.size(); ++i)
		for (size_t k = 0; k < x.size(); ++k) y[i] += a[i][k] * x[k];
	return y;
}

/// Gaussian elimination with partial pivoting.
Vector solved(Matrix a, Vector b)
{
	const size_t n = b.size();
	for (size_t k = 0; k < n; ++k)
	{
		size_t best = k;
		for (size_t i = k + 1; i < n; ++i)
			if (std::fabs(a[i][k]) > std::fabs(a[best][k])) best = i;
		std::swap(a[k], a[best]);
		std::swap(b[k], b[best]);
		for (size_t i = k + 1; i < n; ++i)
		{
			const double f = a[i][k] / a[k][k];
			for (size_t j = k; j < n; ++j) a[i][j] -= f * a[k][j];
			b[i] -= f * b[k];
		}
	}
	for (size_t k = n; k-- > 0;)
	{
		for (size_t j = k + 1; j < n; ++j) b[k] -= a[k][j] * b[j];
		b[k] /= a[k][k];
	}
	return b;
}

Vector six(const ist::Wrench& w) { return {w.force.x, w.force.y, w.force.z, w.torque.x, w.torque.y, w.torque.z}; }
ist::Wrench wrench(const Vector& v) { return {{v[0], v[1], v[2]}, {v[3], v[4], v[5]}}; }
ist::Twist twist(const Vector& v) { return {{v[0], v[1], v[2]}, {v[3], v[4], v[5]}}; }

struct Random
{
	std::mt19937_64 engine;
	explicit Random(uint64_t seed) : engine(seed) {}
	double operator()(double size = 1) { return std::uniform_real_distribution<double>(-size, size)(engine); }
	Vec3 vector(double size = 1)
	{
		const double x = (*this)(size), y = (*this)(size);
		return {x, y, (*this)(size)};
	}
};

/// Matrix G G^T of a random 6 x rank matrix G.
ist::SymmetricMatrix6 positive(Random& random, int rank, double size)
{
	double g[6][6];
	for (auto& row : g)
		for (double& x : row) x = random();
	ist::SymmetricMatrix6 result;
	for (int i = 0; i < 6; ++i)
		for (int j = i; j < 6; ++j)
			for (int k = 0; k < rank; ++k) result(i, j) += size * g[i][k] * g[j][k];
	return result;
}

btVolumetricRowBody randomBody(Random& random, const Vec3& near)
{
	btVolumetricRowBody body;
	const double w = 0.5 + std::fabs(random());
	body.inverseMass = {w, w, w};
	body.center = near + random.vector(0.5);
	const ist::SymmetricMatrix6 spread = positive(random, 4, 1);
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) body.inverseInertia.m[i][j] = spread(i, j) + (i == j ? 1 : 0);
	return body;
}

/// Change of the relative twist at `point` for an impulse there, by Newton's and Euler's equations, one column at a time.
Matrix responseOf(const btVolumetricRowBody& A, const btVolumetricRowBody& B, const Vec3& point)
{
	Matrix W = zeros(6);
	for (size_t column = 0; column < 6; ++column)
	{
		Vector unit(6, 0);
		unit[column] = 1;
		const ist::Wrench impulse = wrench(unit);
		for (const btVolumetricRowBody* body : {&A, &B})
		{
			const Vec3 arm = point - body->center;
			const Vec3 spin = body->inverseInertia * (impulse.torque + cross(arm, impulse.force));
			const Vec3& w = body->inverseMass;
			const Vec3 speed = Vec3{w.x * impulse.force.x, w.y * impulse.force.y, w.z * impulse.force.z} + cross(spin, arm);
			const Vector change = six({speed, spin});
			for (size_t i = 0; i < 6; ++i) W[i][column] += change[i];
		}
	}
	return W;
}

struct Problem
{
	btContactPatch patch;
	btVolumetricRowBody A, B;
	double h = 1.0 / 240;

	explicit Problem(uint64_t seed, int rank = 6, double stiffness = 1e4)
	{
		Random random(seed);
		patch.point = random.vector(seed % 3 ? 3 : 1000);
		patch.normal = ist::normalized(random.vector());
		patch.wrench = {50 * patch.normal, random.vector(1)};
		patch.stiffness = positive(random, rank, stiffness);
		patch.damping = positive(random, rank, 10);
		patch.frictionRadius = 0.1;
		A = randomBody(random, patch.point);
		B = randomBody(random, patch.point);
	}
	Matrix response() const { return responseOf(A, B, patch.point); }
	Matrix softness() const
	{
		Matrix S = zeros(6);
		for (int i = 0; i < 6; ++i)
			for (int j = 0; j < 6; ++j) S[size_t(i)][size_t(j)] = h * h * patch.stiffness(i, j) + h * patch.damping(i, j);
		return S;
	}
	/// Solves (I + S W) L = h w0 - S u.
	Vector direct(const Vector& u) const
	{
		const Matrix S = softness();
		Matrix M = product(S, response());
		for (size_t i = 0; i < 6; ++i) M[i][i] += 1;
		Vector b = six(h * patch.wrench);
		const Vector Su = product(S, u);
		for (size_t i = 0; i < 6; ++i) b[i] -= Su[i];
		return solved(M, b);
	}
};

/// Visits the row until nothing changes, with the response of its impulse. Returns the relative twist at the end.
Vector iterate(btVolumetricRow& row, const Problem& p, const Vector& u, int visits = 20)
{
	const Matrix W = p.response();
	Vector now = u;
	for (int i = 0; i < visits; ++i)
	{
		const Vector change = product(W, six(row.solve(twist(now))));
		for (size_t k = 0; k < 6; ++k) now[k] += change[k];
	}
	return now;
}

Vector randomTwist(uint64_t seed, double size)
{
	Random random(seed + 1000);
	Vector u;
	for (int i = 0; i < 6; ++i) u.push_back(random(size));
	return u;
}

/// A flat contact with the normal y and the given friction radius. The two unit bodies are centred on the line of the normal.
Problem sliding(double radius)
{
	Problem p(1);
	p.patch.point = {4, -2, 7};
	p.patch.normal = {0, 1, 0};
	p.patch.wrench = {{0, 100, 0}, {}};
	p.patch.stiffness = {};
	p.patch.damping = {};
	p.patch.frictionRadius = radius;
	p.A = {};
	p.A.inverseMass = {1, 1, 1};
	p.A.center = p.patch.point;
	for (int i = 0; i < 3; ++i) p.A.inverseInertia.m[i][i] = 10;
	p.B = {};
	p.B.center = {4, -3, 7};
	return p;
}
}  // namespace

TEST(VolumetricRow, ElasticBlockIsTheDirectSolutionOfTheImplicitStep)
{
	for (uint64_t seed = 0; seed < 30; ++seed)
		for (const int rank : {1, 3, 6})
		{
			const Problem p(seed, rank);
			const Vector u = randomTwist(seed, 0.1), expected = p.direct(u);
			btVolumetricRow row;
			row.prepare(p.patch, p.A, p.B, p.h, 0);
			const Vector after = iterate(row, p, u);
			const bool pushes = dot(wrench(expected).force, p.patch.normal) > 0;
			const Vector found = six(row.impulse());
			double size = 0;
			for (const double x : expected) size = std::max(size, std::fabs(x));
			for (size_t i = 0; i < 6; ++i) EXPECT_NEAR(found[i], pushes ? expected[i] : 0, 1e-9 * size) << seed << " rank " << rank;
			const Vector moved = product(p.response(), found);
			for (size_t i = 0; i < 6; ++i) EXPECT_NEAR(after[i], u[i] + moved[i], 1e-9);
		}
}

TEST(VolumetricRow, NeverPulls)
{
	for (uint64_t seed = 0; seed < 50; ++seed)
	{
		const Problem p(seed);
		btVolumetricRow row;
		row.prepare(p.patch, p.A, p.B, p.h, 0.7);
		Vector u = randomTwist(seed, 0.1);
		u[0] += 20 * p.patch.normal.x, u[1] += 20 * p.patch.normal.y, u[2] += 20 * p.patch.normal.z;
		iterate(row, p, u);
		EXPECT_GE(row.normalImpulse(), 0);
		// The bodies separate at 20 m/s, so the contact is released.
		EXPECT_LT(norm(row.impulse().force) + norm(row.impulse().torque), 1e-12) << seed;
	}
}

// One body on a spring and damper along the normal: with steps of h the result approaches the closed form m x'' = -k x - c x' linearly in
// h.
TEST(VolumetricRow, SmallStepsFollowTheDampedSpring)
{
	const double k = 400, c = 4, x0 = -0.1, end = 0.05;  // released at x0 < 0, which is inside
	const double w = std::sqrt(k - c * c / 4);
	const double expected = std::exp(-c / 2 * end) * x0 * (std::cos(w * end) + c / 2 / w * std::sin(w * end));
	double error[2];
	for (int pass = 0; pass < 2; ++pass)
	{
		Problem p = sliding(0);
		p.h = pass ? 1e-5 : 1e-4;
		p.patch.stiffness(1, 1) = k;
		p.patch.damping(1, 1) = c;
		double x = x0, v = 0;
		for (int i = 0; i < int(end / p.h + 0.5); ++i)
		{
			p.patch.wrench = {{0, -k * x, 0}, {}};
			btVolumetricRow row;
			row.prepare(p.patch, p.A, p.B, p.h, 0);
			v = iterate(row, p, {0, v, 0, 0, 0, 0}, 1)[1];
			x += p.h * v;
		}
		error[pass] = std::fabs(x - expected);
	}
	EXPECT_LT(error[1], 1e-4 * std::fabs(x0));
	EXPECT_NEAR(error[0] / error[1], 10, 1);
}

TEST(VolumetricRow, StickingLeavesNoSlip)
{
	for (uint64_t seed = 0; seed < 30; ++seed)
	{
		Problem p(seed);
		btVolumetricRow row;
		row.prepare(p.patch, p.A, p.B, p.h, 1e3);
		const Vector after = iterate(row, p, randomTwist(seed, 0.01), 50);
		if (row.normalImpulse() == 0) continue;
		const ist::Twist t = twist(after);
		const Vec3 slip = t.linear - dot(t.linear, p.patch.normal) * p.patch.normal;
		EXPECT_LT(norm(slip), 1e-9) << seed;
		EXPECT_LT(std::fabs(dot(t.angular, p.patch.normal)) * p.patch.frictionRadius, 1e-9) << seed;
	}
}

TEST(VolumetricRow, SlidingIsBrakedByMuTimesTheNormalForceAgainstTheSlip)
{
	const double mu = 0.4;
	for (int i = 0; i < 24; ++i)
	{
		const double heading = 0.2618 * i + 0.05;
		const Problem p = sliding(0.1);
		btVolumetricRow row;
		row.prepare(p.patch, p.A, p.B, p.h, mu);
		const Vec3 direction{std::cos(heading), 0, std::sin(heading)};
		iterate(row, p, {5 * direction.x, 0, 5 * direction.z, 0, 0, 0});
		const double normal = 100 * p.h;
		EXPECT_NEAR(row.normalImpulse(), normal, 1e-12);
		EXPECT_LT(norm(row.impulse().force - (Vec3{0, normal, 0} - mu * normal * direction)), 1e-9 * normal) << heading;
		EXPECT_LT(norm(row.impulse().torque), 1e-12);
	}
}

TEST(VolumetricRow, SpinningIsBrakedByMuTimesTheNormalForceTimesTheFrictionRadius)
{
	const double mu = 0.4, radius = 0.1;
	const Problem p = sliding(radius);
	btVolumetricRow row;
	row.prepare(p.patch, p.A, p.B, p.h, mu);
	iterate(row, p, {0, 0, 0, 0, 50, 0});
	EXPECT_NEAR(row.impulse().torque.y, -mu * radius * 100 * p.h, 1e-12);
	btVolumetricRow point;
	point.prepare(sliding(0).patch, p.A, p.B, p.h, mu);
	iterate(point, sliding(0), {0, 0, 0, 0, 50, 0});
	EXPECT_EQ(point.impulse().torque.y, 0);
}

// The two bodies turn about the contact, so that nothing but rolling friction brakes them.
TEST(VolumetricRow, RollingAndSpinningAreBrakedByLengthsTimesTheNormalForce)
{
	for (const double mu : {0.0, 0.4})
		for (int i = 0; i < 24; ++i)
		{
			const double heading = 0.2618 * i + 0.05, rolling = 0.03, spinning = 0.02;
			const Problem p = sliding(0);
			const double normal = 100 * p.h;
			for (const Vec3& axis : {Vec3{std::cos(heading), 0, std::sin(heading)}, Vec3{0, 1, 0}})
			{
				btVolumetricRow row;
				row.prepare(p.patch, p.A, p.B, p.h, {mu, rolling, spinning});
				iterate(row, p, {0, 0, 0, 50 * axis.x, 50 * axis.y, 50 * axis.z});
				EXPECT_NEAR(row.normalImpulse(), normal, 1e-9 * normal);
				const double limit = (axis.y > 0 ? spinning : rolling) * normal;
				EXPECT_LT(norm(row.impulse().torque + limit * axis), 1e-9 * limit) << heading << ' ' << mu;
				// 1e-6 rad/s is less than the friction can stop.
				btVolumetricRow held;
				held.prepare(p.patch, p.A, p.B, p.h, {mu, rolling, spinning});
				const Vector after = iterate(held, p, {0, 0, 0, 1e-6 * axis.x, 1e-6 * axis.y, 1e-6 * axis.z}, 50);
				EXPECT_LT(norm(twist(after).angular), 1e-12) << heading << ' ' << mu;
			}
		}
}

TEST(VolumetricRow, StaysFiniteAndInBoundsInHardCases)
{
	for (uint64_t seed = 0; seed < 40; ++seed)
		for (const double stiffness : {0.0, 1.0, 1e12})
			for (const int bodies : {0, 1, 2, 3})
			{
				Problem p(seed, seed % 2 ? 1 : 6, stiffness);
				if (seed % 4 == 0) p.patch.frictionRadius = 0;
				if (bodies == 0) p.B = {};
				if (bodies == 1) p.A.inverseInertia = ist::zeroMat3();
				if (bodies == 2) p.B = {}, p.A.inverseMass.x = 0, p.A.inverseInertia = ist::zeroMat3();
				if (bodies == 3) p.A = {}, p.B = {};
				btVolumetricRow row;
				row.prepare(p.patch, p.A, p.B, p.h, {0.6, seed % 3 == 0 ? 0.1 : 0, seed % 3 < 2 ? 0.2 : 0});
				const Vector after = iterate(row, p, randomTwist(seed, 1));
				EXPECT_TRUE(ist::isFinite(row.impulse())) << seed << " " << stiffness << " " << bodies;
				for (const double x : after) EXPECT_TRUE(std::isfinite(x));
				EXPECT_GE(row.normalImpulse(), 0);
			}
}

// For an infinitely stiff spring along the normal, the step ends with the penetration gone: u = w0 / (h K).
TEST(VolumetricRow, HugeStiffnessGivesTheVelocityThatLeavesInOneStep)
{
	Problem p = sliding(0.1);
	p.patch.stiffness(1, 1) = 1e12;
	p.patch.wrench = {{0, 1e12 * 1e-6, 0}, {}};
	btVolumetricRow row;
	row.prepare(p.patch, p.A, p.B, p.h, 0);
	EXPECT_NEAR(iterate(row, p, {0, -3, 0, 0, 0, 0})[1], 1e-6 / p.h, 1e-6);
}
