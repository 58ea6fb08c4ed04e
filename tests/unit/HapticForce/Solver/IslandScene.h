// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Solver/btIslandBlockSolver.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

// Random islands for tests of the block solver.
namespace island
{
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;
constexpr double kStep = 1.0 / 60;

/// Random bodies and patches. Immovable bodies have the index -1.
struct Scene
{
	std::vector<btVolumetricRowBody> bodies;
	std::vector<ist::Twist> free;
	struct Contact
	{
		btContactPatch patch;
		int a, b;
		ist::Twist given;
		btContactFriction friction;
	};
	std::vector<Contact> contacts;
	std::mt19937_64 random;
	ist::Vec3 origin;
	double speed;

	explicit Scene(uint64_t seed, double maxSpeed = 1) : random(seed), speed(maxSpeed)
	{
		if (seed % 4 == 0) origin = {1000, -2000, 500};
	}
	double uniform(double from, double to) { return std::uniform_real_distribution<double>(from, to)(random); }
	ist::Vec3 vector(double size = 1) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }

	int addBody(double mass)
	{
		btVolumetricRowBody b;
		b.inverseMass = {1 / mass, 1 / mass, 1 / mass};
		const ist::Mat3 R = rotationMatrix(ist::quaternionFromRotationVector(vector(3)));
		ist::Mat3 diagonal = ist::zeroMat3();
		for (int i = 0; i < 3; ++i) diagonal.m[i][i] = uniform(3, 12) / mass;
		b.inverseInertia = R * diagonal * transpose(R);
		b.center = origin + vector(0.5);
		bodies.push_back(b);
		free.push_back({vector(speed), vector(speed)});
		return int(bodies.size()) - 1;
	}
	/// Adds a patch of `points` springs within 20 cm and 15 degrees of its normal, each slightly compressed.
	void addContact(int a, int b, double stiffness, const btContactFriction& friction, int points = 6)
	{
		Contact c{{}, a, b, {}, friction};
		if (b < 0) c.given = {vector(0.1 * speed), vector(0.1 * speed)};
		c.patch.point = origin + vector(0.5);
		const ist::Vec3 axis = normalized(vector());
		c.patch.frictionRadius = uniform(0.01, 0.2);
		for (int r = 0; r < points; ++r)
		{
			const ist::Vec3 n = normalized(axis + vector(0.15)), moment = cross(vector(0.2), n);
			const double depth = uniform(0, 0.01);
			c.patch.wrench = c.patch.wrench + stiffness * depth * ist::Wrench{n, moment};
			const double g[6] = {n.x, n.y, n.z, moment.x, moment.y, moment.z};
			for (int i = 0; i < 6; ++i)
				for (int j = i; j < 6; ++j)
				{
					c.patch.stiffness(i, j) += stiffness * g[i] * g[j];
					c.patch.damping(i, j) += 0.01 * stiffness * g[i] * g[j];
				}
		}
		c.patch.normal = normalized(c.patch.wrench.force);
		contacts.push_back(c);
	}
	/// Leaves of a patch what pushes along its normal.
	static void makePoint(btContactPatch& p)
	{
		const ist::Vec3 n = p.normal;
		p.wrench = {dot(p.wrench.force, n) * n, {}};
		for (ist::SymmetricMatrix6* matrix : {&p.stiffness, &p.damping})
		{
			double size = 0;
			for (int i = 0; i < 3; ++i)
				for (int j = 0; j < 3; ++j) size += n[i] * (*matrix)(std::min(i, j), std::max(i, j)) * n[j];
			*matrix = ist::SymmetricMatrix6();
			for (int i = 0; i < 3; ++i)
				for (int j = i; j < 3; ++j) (*matrix)(i, j) = size * n[i] * n[j];
		}
	}
	void makePoints(const btIslandBlockSolver& solver)
	{
		for (size_t k = 0; k < contacts.size(); ++k)
			if (solver.isPoint(int(k))) makePoint(contacts[k].patch);
	}
	bool solve(btIslandBlockSolver& solver) const
	{
		solver.clear();
		for (const auto& b : bodies) solver.addBody(b);
		for (const auto& c : contacts) solver.addPatch(c.patch, c.a, c.b, c.given, kStep, c.friction);
		return solver.solve(free.data());
	}

	// The rest of the class is plain dynamics, without the solver's square roots.
	Mat6 jacobian(const Contact& c, int body) const
	{
		const ist::Vec3 r = c.patch.point - bodies[size_t(body)].center;
		Mat6 J = Mat6::Identity();
		J.topRightCorner<3, 3>() << 0, r.z, -r.y, -r.z, 0, r.x, r.y, -r.x, 0;
		return J;
	}
	Mat6 inverseMass(int body) const
	{
		Mat6 m = Mat6::Zero();
		const auto& b = bodies[size_t(body)];
		m.diagonal().head<3>() << b.inverseMass.x, b.inverseMass.y, b.inverseMass.z;
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j) m(3 + i, 3 + j) = b.inverseInertia.m[i][j];
		return m;
	}
	Mat6 S(const Contact& c) const
	{
		Mat6 s;
		for (int i = 0; i < 6; ++i)
			for (int j = 0; j < 6; ++j) s(i, j) = kStep * kStep * c.patch.stiffness(i, j) + kStep * c.patch.damping(i, j);
		return s;
	}
	Vec6 push(const Contact& c) const { return kStep * vec(c.patch.wrench.force, c.patch.wrench.torque); }
	static Vec6 vec(const ist::Vec3& a, const ist::Vec3& b)
	{
		Vec6 v;
		v << a.x, a.y, a.z, b.x, b.y, b.z;
		return v;
	}
	static Eigen::Vector3d eigen(const ist::Vec3& v) { return {v.x, v.y, v.z}; }
	Eigen::VectorXd denseImpulses(const std::vector<size_t>& active) const
	{
		const Eigen::Index n = Eigen::Index(6 * active.size());
		if (n == 0) return {};
		Eigen::MatrixXd A = Eigen::MatrixXd::Identity(n, n);
		Eigen::VectorXd right(n);
		std::vector<Vec6> v;
		for (const auto& t : free) v.push_back(vec(t.linear, t.angular));
		for (size_t i = 0; i < active.size(); ++i)
		{
			const Contact& c = contacts[active[i]];
			right.segment<6>(Eigen::Index(6 * i)) = push(c) - S(c) * relative(c, v);
			for (size_t j = 0; j < active.size(); ++j)
			{
				const Contact& d = contacts[active[j]];
				for (const auto& [mine, sign] : {std::pair(c.a, 1.0), std::pair(c.b, -1.0)})
					for (const auto& [its, itsSign] : {std::pair(d.a, 1.0), std::pair(d.b, -1.0)})
						if (mine >= 0 && mine == its)
							A.block<6, 6>(Eigen::Index(6 * i), Eigen::Index(6 * j)) += sign * itsSign * S(c) * jacobian(c, mine) *
								inverseMass(mine) * jacobian(d, mine).transpose();
			}
		}
		return A.fullPivLu().solve(right);
	}
	/// Twists of the bodies after the impulses that the solver returns.
	std::vector<Vec6> after(const btIslandBlockSolver& solver) const
	{
		std::vector<Vec6> v;
		for (const auto& t : free) v.push_back(vec(t.linear, t.angular));
		for (size_t k = 0; k < contacts.size(); ++k)
		{
			const ist::Wrench w = solver.impulse(int(k));
			const Contact& c = contacts[k];
			if (c.a >= 0) v[size_t(c.a)] += inverseMass(c.a) * jacobian(c, c.a).transpose() * vec(w.force, w.torque);
			if (c.b >= 0) v[size_t(c.b)] -= inverseMass(c.b) * jacobian(c, c.b).transpose() * vec(w.force, w.torque);
		}
		return v;
	}
	Vec6 relative(const Contact& c, const std::vector<Vec6>& v) const
	{
		Vec6 u = vec(c.given.linear, c.given.angular);
		if (c.a >= 0) u += jacobian(c, c.a) * v[size_t(c.a)];
		if (c.b >= 0) u -= jacobian(c, c.b) * v[size_t(c.b)];
		return u;
	}
};

inline Scene randomScene(uint64_t seed, const btContactFriction& friction, double stiffness, double maxSpeed = 1)
{
	Scene scene(seed, maxSpeed);
	const int n = 2 + int(seed % 6);
	for (int i = 0; i < n; ++i) scene.addBody(std::pow(10, scene.uniform(-2, 2)));
	for (int i = 0; i < n; ++i) scene.addContact(i, i - 1, stiffness, friction);
	for (int i = 0; i < n; ++i)
		scene.addContact(int(seed + uint64_t(i)) % n,
			int(seed * 7 + uint64_t(3 * i) + 1) % n == int(seed + uint64_t(i)) % n ? -1 : int(seed * 7 + uint64_t(3 * i) + 1) % n,
			stiffness, friction, 2);
	return scene;
}

/// Ten bodies press on one from all sides through two patches each, like the parts of a hand.
inline Scene heldScene(uint64_t seed)
{
	Scene scene(seed, 0.05);
	const int held = scene.addBody(1), parts = 10;
	scene.free[size_t(held)].linear.z -= 9.81 * kStep;
	for (int i = 0; i < parts; ++i)
	{
		const double angle = 2 * std::numbers::pi * i / parts;
		const ist::Vec3 inwards{-std::cos(angle), -std::sin(angle), 0};
		const int part = scene.addBody(0.2);
		scene.bodies[size_t(part)].center = scene.bodies[size_t(held)].center - 0.6 * inwards;
		for (int k = 0; k < 2; ++k)
		{
			scene.addContact(part, held, 2000, 0.5);
			btContactPatch& patch = scene.contacts.back().patch;
			patch = {};
			patch.point = scene.bodies[size_t(held)].center - 0.4 * inwards + scene.vector(0.1);
			patch.normal = normalized(scene.vector(0.1) - inwards);
			patch.wrench.force = scene.uniform(0.5, 2) * patch.normal;
			// This velocity pushes the part inwards, so that the depth of the patch stays.
			scene.free[size_t(part)].linear = scene.free[size_t(part)].linear - kStep / 0.2 * patch.wrench.force;
			patch.frictionRadius = 0.04;
			for (int axis = 0; axis < 3; ++axis)
			{
				for (int other = axis; other < 3; ++other) patch.stiffness(axis, other) = 2000 * patch.normal[axis] * patch.normal[other];
				patch.stiffness(3 + axis, 3 + axis) = 2000 * 2e-3;
			}
		}
	}
	return scene;
}
}  // namespace island
